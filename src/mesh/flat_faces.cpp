#include "src/mesh/flat_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace overtet {

std::vector<Index> flat_faces(const Surface& s, double relative, double reach) {
  std::vector<Index> flat;
  for (Index f = 0; f < s.F.rows(); ++f) {
    const Eigen::Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
    const double longest =
        std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    const double largest =
        std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff(), reach});
    if ((b - a).cross(c - a).norm() <= relative * largest * longest) flat.push_back(f);
  }
  return flat;
}

}  // namespace overtet
