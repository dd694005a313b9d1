// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// Tets a face of the surface, from which on most tets are far from all faces.
constexpr int kManyTets = 16;

}  // namespace overtet
