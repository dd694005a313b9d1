// What can be chosen in this room, with units and reasons; OpeningOptions has what its users may choose.
#pragma once

namespace overtet {

// Vertices are inserted and removed only where the least quality is more than this part of what is wanted:
// before that it is larger balls that help, for a tenth of the time.
constexpr double kNearTarget = 0.3;

}  // namespace overtet
