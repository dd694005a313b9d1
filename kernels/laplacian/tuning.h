// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// Relative to a triangle's longest edge squared, or to the mean area of a vertex: areas below this are
// rounding noise, and what is divided by them is taken as if they were so large.
constexpr double kAreaFloor = 1e-10;

}  // namespace overtet
