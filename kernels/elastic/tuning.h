// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// The part of its rest volume below which a tet resists being flattened by more than its material says: far
// below what the materials are good for, so that nothing changes where they are.
constexpr double kBarrierVolume = 0.05;

}  // namespace overtet
