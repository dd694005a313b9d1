#include "kernels/elastic/flat_time.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "kernels/core/tuning.h"

namespace overtet {

namespace {

// A cubic polynomial on an interval, by its Bernstein coefficients: it lies in their convex hull.
using Cubic = std::array<double, 4>;

// No root before the answer; `end` where there is none at all.
double first_root(const Cubic& b, double begin, double end) {
  if (std::all_of(b.begin(), b.end(), [](double x) { return x > 0; })) return end;
  if (!(b[0] > 0) || end - begin <= kPrecise * begin || end - begin <= kRoundedLength) return begin;
  // In two halves: de Casteljau.
  Cubic left, right = b;
  for (int i = 0; i < 4; ++i) {
    left[i] = right[0];
    for (int k = 0; k + i < 3; ++k) right[k] = (right[k] + right[k + 1]) / 2;
  }
  const double middle = (begin + end) / 2, root = first_root(left, begin, middle);
  return root < middle ? root : first_root(right, middle, end);
}

}  // namespace

double first_flat_time(const Eigen::Matrix<double, 3, 4>& x, const Eigen::Matrix<double, 3, 4>& d,
                       double most) {
  Eigen::Vector3d p[3], q[3];
  for (int k = 0; k < 3; ++k) {
    p[k] = x.col(k + 1) - x.col(0);
    q[k] = p[k] + most * (d.col(k + 1) - d.col(0));
  }
  const auto det = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return a.dot(b.cross(c));
  };
  // Six volumes, between time 0 and `most`.
  const Cubic volume{
      det(p[0], p[1], p[2]), (det(q[0], p[1], p[2]) + det(p[0], q[1], p[2]) + det(p[0], p[1], q[2])) / 3,
      (det(p[0], q[1], q[2]) + det(q[0], p[1], q[2]) + det(q[0], q[1], p[2])) / 3, det(q[0], q[1], q[2])};
  return most * first_root(volume, 0, 1);
}

}  // namespace overtet
