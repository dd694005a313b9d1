// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Radians: hinges that open less are not named, see Hinge::opening.
constexpr double kCheckableOpening = 1e-9;
// Covered edges that lead further than this from odd hinges are a case for others: every edge costs exact
// rays.
constexpr std::size_t kMostCoveredEdges = 400;
// Directions tried, besides those of the normals around a hinge.
constexpr int kScattered = 48;
// Of their coordinates: short integers are easy to check.
constexpr double kLongest = 1000;
// Points looked at in the overlap of two faces; another one where the one before lies on an edge.
constexpr int kOverlapPoints = 3;

}  // namespace overtet
