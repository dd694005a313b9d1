// How far a tet may go before it is flat.
#pragma once

#include <Eigen/Core>

namespace overtet {

// The first time t > 0 at which the tet x + t d has no volume, d its corners' ways, if that is before `most`;
// else `most`. The volume is a cubic polynomial of t: its first root, from below, to a share of kPrecise of
// it. 0 where x has no positive volume itself.
double first_flat_time(const Eigen::Matrix<double, 3, 4>& x, const Eigen::Matrix<double, 3, 4>& d,
                       double most);

}  // namespace overtet
