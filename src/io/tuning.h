// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Corners of a polygon: up to so many the best ear of all is cut (cubic time), up to so many any ear
// (quadratic), beyond them it becomes a fan.
constexpr std::size_t kBestEarCorners = 64, kMaxEarCorners = 1024;

}  // namespace overtet
