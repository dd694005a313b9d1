// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Faces that are looked at while a small polyhedron is filled with tets: what is found at all is mostly found
// before.
constexpr int kFillSteps = 300;
// Tets of a cavity, or around an edge, that are taken apart and filled anew: the time grows exponentially.
constexpr std::size_t kMostTetsFilled = 40;

}  // namespace overtet
