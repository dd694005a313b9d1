// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Unknowns of a field from which on multigrid solves faster than a factor (perf/README.md).
constexpr std::ptrdiff_t kMultigridUnknowns = 500;

}  // namespace overtet
