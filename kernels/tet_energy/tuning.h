// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// The smallest dihedral sine of an exactly positive tet whose computed volume is not above zero: worse than
// any that can be computed.
constexpr double kThinnestSine = 1e-30;

}  // namespace overtet
