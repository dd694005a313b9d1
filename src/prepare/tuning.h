// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Edges of the largest hole for which all triangulations are searched where the Delaunay tetrahedra of its
// vertices have none: that takes the cube of their number, a second for so many.
constexpr std::size_t kCubicEdges = 500;

}  // namespace overtet
