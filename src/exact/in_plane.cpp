#include "src/exact/in_plane.h"

#include <cmath>

#include "kernels/predicates/predicates.h"

namespace overtet::exact {

PlaneView::PlaneView(const Rays& rays, Index f) {
  const double *a = rays.corner(f, 0), *b = rays.corner(f, 1), *c = rays.corner(f, 2);
  const auto n = rays.unit_normal(f);
  int best = 0;
  for (int k = 1; k < 3; ++k)
    if (std::fabs(n[k]) > std::fabs(n[best])) best = k;
  for (int k = 0;; ++k) {
    axis_ = (best + k) % 3;
    const int i = (axis_ + 1) % 3, j = (axis_ + 2) % 3;
    up_ = orient2d(a[i], a[j], b[i], b[j], c[i], c[j]);
    if (up_ != 0) return;
  }
}

PlaneView::Crossing PlaneView::crossing(const Point& from, const Point& to, const double* a,
                                        const double* b) const {
  const int i = (axis_ + 1) % 3, j = (axis_ + 2) % 3;
  const auto height = [&](const Point& p) -> Rational {
    return (Rational(b[i]) - a[i]) * (p.x[j] - a[j]) - (Rational(b[j]) - a[j]) * (p.x[i] - a[i]);
  };
  const auto side_of = [&](const Point& p) {
    return p.in_doubles ? side(a, b, p.near.data()) : up_ * sign(height(p));
  };
  Crossing out{side_of(from), side_of(to), {}, {}};
  if (!out.crosses()) return out;
  out.from_height = height(from);
  out.to_height = height(to);
  return out;
}

int PlaneView::side(const double* a, const double* b, const double* p) const {
  const int i = (axis_ + 1) % 3, j = (axis_ + 2) % 3;
  return up_ * orient2d(a[i], a[j], b[i], b[j], p[i], p[j]);
}

}  // namespace overtet::exact
