// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Covered edges that lead further than this from odd hinges are a case for others: every edge costs exact
// rays.
constexpr std::size_t kMostCoveredEdges = 400;
// Directions tried, besides those of the normals around a hinge.
constexpr int kScattered = 48;
// Of their coordinates: short integers are easy to check.
constexpr double kLongest = 1000;

}  // namespace overtet
