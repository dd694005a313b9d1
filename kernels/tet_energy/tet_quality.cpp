#include "kernels/tet_energy/tet_quality.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/core/assertions.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"
#include "kernels/tet_energy/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

}  // namespace

double min_dihedral_sine(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d ab = b - a, ac = c - a, ad = d - a, bc = c - b, bd = d - b, cd = d - c;
  const Vector3d nd = ab.cross(ac), nc = ad.cross(ab), nb = ac.cross(ad), na = bd.cross(bc);
  const double det = nd.dot(ad);
  // A filter on numbers that are here anyway: at most 8 roundings in each of 6 products.
  const double size = ab.cwiseAbs().maxCoeff() * ac.cwiseAbs().maxCoeff() * ad.cwiseAbs().maxCoeff();
  if (!(det > 1e-14 * size && size > 1e-250)) {
    if (orient3d(a.data(), b.data(), c.data(), d.data()) <= 0) return 0;
    if (!(det > 0)) return kThinnestSine;
  }
  // sin at an edge = det * length / (product of the two normals beside it), everything squared.
  const double qa = na.squaredNorm(), qb = nb.squaredNorm(), qc = nc.squaredNorm(), qd = nd.squaredNorm();
  const double least =
      std::min({ab.squaredNorm() / (qc * qd), ac.squaredNorm() / (qb * qd), bc.squaredNorm() / (qa * qd),
                ad.squaredNorm() / (qb * qc), bd.squaredNorm() / (qa * qc), cd.squaredNorm() / (qa * qb)});
  const double sine = det * std::sqrt(least);
  return sine > kThinnestSine ? std::min(sine, 1.0) : kThinnestSine;  // also when a face has no computed area
}

void dihedral_sines(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d,
                    DihedralSines& out) {
  OVERTET_EXPECTS(a != b && a != c && a != d && b != c && b != d && c != d);
  const Vector3d ab = b - a, bc = c - b, ca = a - c, ad = d - a, bd = d - b, cd = d - c;
  const Vector3d nd = bc.cross(ca);  // of abc
  // Normals of the faces at d, and the gradient of the logarithm of their length.
  const Vector3d nc = ab.cross(ad), na = bc.cross(bd), nb = ca.cross(cd);
  const double qa = na.squaredNorm(), qb = nb.squaredNorm(), qc = nc.squaredNorm(), qd = nd.squaredNorm();
  const Vector3d ga = na.cross(bc) / qa, gb = nb.cross(ca) / qb, gc = nc.cross(ab) / qc;
  // A volume lost in rounding still has a direction in which it grows.
  const double det = std::max(nd.dot(ad), 1e-17 * std::sqrt(qd) * ad.norm());
  const Vector3d gv = nd / det;
  const double la = std::sqrt(qa), lb = std::sqrt(qb), lc = std::sqrt(qc), ld = std::sqrt(qd);
  out.sine = {det * ab.norm() / (lc * ld), det * bc.norm() / (la * ld), det * ca.norm() / (lb * ld),
              det * ad.norm() / (lb * lc), det * bd.norm() / (la * lc), det * cd.norm() / (la * lb)};
  out.log_gradient = {gv - gc,
                      gv - ga,
                      gv - gb,
                      gv + ad / ad.squaredNorm() - gb - gc,
                      gv + bd / bd.squaredNorm() - ga - gc,
                      gv + cd / cd.squaredNorm() - ga - gb};
}

std::array<double, 6> dihedral_angles(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                                      const Vector3d& d) {
  const Vector3d ab = b - a, bc = c - b, ca = a - c, ad = d - a, bd = d - b, cd = d - c;
  const Vector3d nd = bc.cross(ca), nc = ab.cross(ad), na = bc.cross(bd), nb = ca.cross(cd);
  const double det = std::fabs(nd.dot(ad));
  // nd points to d's side, the others point out of the faces opposite to their letters or into them
  // alike: ab, bc, ca see the angle between nd and the turned normal; ad, bd, cd between two of a kind.
  return {std::atan2(det * ab.norm(), nd.dot(nc)),  std::atan2(det * ca.norm(), nd.dot(nb)),
          std::atan2(det * ad.norm(), -nb.dot(nc)), std::atan2(det * bc.norm(), nd.dot(na)),
          std::atan2(det * bd.norm(), -na.dot(nc)), std::atan2(det * cd.norm(), -na.dot(nb))};
}

double solid_angle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d x = a - d, y = b - d, z = c - d;
  const double lx = x.norm(), ly = y.norm(), lz = z.norm();
  const double angle = 2 * std::atan2(std::fabs(x.dot(y.cross(z))),
                                      lx * ly * lz + x.dot(y) * lz + y.dot(z) * lx + z.dot(x) * ly);
  return angle < 0 ? angle + 4 * M_PI : angle;
}

DihedralStatistics dihedral_statistics(const VertexMatrix& V, const TetMatrix& T) {
  DihedralStatistics s;
  s.tets = T.rows();
  if (s.tets == 0) return s;
  std::vector<double> smallest(T.rows());
  s.max = parallel_reduce(
      T.rows(), kLightGrain, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double largest = 0;
        for (std::int64_t t = begin; t < end; ++t) {
          const auto angles = dihedral_angles(V.row(T(t, 0)), V.row(T(t, 1)), V.row(T(t, 2)), V.row(T(t, 3)));
          const auto [low, high] = std::minmax_element(angles.begin(), angles.end());
          smallest[t] = *low * 180 / M_PI;
          largest = std::max(largest, *high * 180 / M_PI);
        }
        return largest;
      },
      [](double x, double y) { return std::max(x, y); });
  auto left = smallest.begin();  // from the largest percentile down, in what lies below the one before
  const auto percentile = [&](double p) {
    const auto at =
        smallest.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(smallest.size() - 1));
    std::nth_element(smallest.begin(), at, left);
    left = at;
    return *at;
  };
  left = smallest.end();
  s.median = percentile(.5);
  s.p05 = percentile(.05);
  s.p01 = percentile(.01);
  s.min = percentile(0);
  return s;
}

}  // namespace overtet
