// Where a ray meets a triangle, in doubles [Moeller and Trumbore 1997]: for choosing where to move, not for
// deciding anything.
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace overtet {

struct RayHit {
  double far;   // from p, in lengths of d; > 0
  double u, v;  // the place is (1 - u - v) a + u b + v c
};

inline std::optional<RayHit> ray_hit(const Eigen::Vector3d& p, const Eigen::Vector3d& d,
                                     const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                     const Eigen::Vector3d& c) {
  const Eigen::Vector3d e = b - a, g = c - a, q = d.cross(g), t = p - a;
  const double det = e.dot(q);
  if (!(det != 0)) return std::nullopt;
  const RayHit hit{g.dot(t.cross(e)) / det, t.dot(q) / det, d.dot(t.cross(e)) / det};
  if (!(hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1 && hit.far > 0)) return std::nullopt;
  return hit;
}

}  // namespace overtet
