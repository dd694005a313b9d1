// What can be chosen in this room, with units and reasons.
#pragma once

#include <cstddef>

namespace overtet {

// The smallest dihedral sine of an exactly positive tet whose computed volume is not above zero: worse than
// any that can be computed.
constexpr double kThinnestSine = 1e-30;

// Tets that are looked at together: the doubles of a register of AVX2. Two registers of SSE2 do as well,
// wider ones would mostly be empty: a vertex has some 24 tets.
constexpr std::size_t kLanes = 4;

}  // namespace overtet
