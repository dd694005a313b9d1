// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// Rows from which on metis orders a matrix (perf/README.md).
constexpr std::ptrdiff_t kMetisRows = 200000;

}  // namespace overtet
