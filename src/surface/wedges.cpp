#include "src/surface/wedges.h"

#include <algorithm>
#include <cmath>

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::RayCount;
using exact::RayStatus;
using exact::Vec;

constexpr int kAttempts = 12;  // other directions or places when a ray grazes an edge

Rational inverse_length(const Vec& x) {
  const auto a = exact::approximate(x);
  const double big = std::max(std::max(std::fabs(a[0]), std::fabs(a[1])), std::fabs(a[2]));
  return big > 1e-290 && big < 1e290 ? Rational(1 / big) : Rational(1);
}

}  // namespace

Partners::Partners(const std::vector<FacePair>& pairs) {
  list_.reserve(2 * pairs.size());
  for (const auto& [f, g] : pairs) list_.emplace_back(f, g), list_.emplace_back(g, f);
  std::sort(list_.begin(), list_.end());
}

std::vector<Index> Partners::common(Index f, Index g) const {
  std::vector<Index> out;
  auto i = std::lower_bound(list_.begin(), list_.end(), FacePair(f, -1));
  auto j = std::lower_bound(list_.begin(), list_.end(), FacePair(g, -1));
  while (i != list_.end() && j != list_.end() && i->first == f && j->first == g) {
    if (i->second == j->second) {
      out.push_back(i->second);
      ++i, ++j;
    } else if (i->second < j->second) {
      ++i;
    } else {
      ++j;
    }
  }
  return out;
}

std::optional<Wedge> Wedges::in_front(Index f, Index g, const Vec& u, const Vec& from, const Vec& along,
                                      const Rational& t0, const Rational& t1) const {
  const std::vector<Index> skip{std::min(f, g), std::max(f, g)};
  const Vec nf = rays_.normal(f), ng = rays_.normal(g);
  const auto a = rays_.unit_normal(f), b = rays_.unit_normal(g);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Rational part(1 + attempt % 5);
    const Point m(from + ((part * t0 + t1) / (part + 1)) * along);
    const double weight = 1 + 0.4 * exact::scatter(attempt);
    const double sum[3] = {a[0] + weight * b[0], a[1] + weight * b[1], a[2] + weight * b[2]};
    Point d(sum);
    if (exact::sign(dot(nf, d.x)) <= 0 || exact::sign(dot(ng, d.x)) <= 0) {
      // A wedge too thin for doubles: u x nf and ng x u span it.
      const Vec p = exact::cross(u, nf), q = exact::cross(ng, u);
      d = Point(Rational(weight) * (inverse_length(p) * p) + inverse_length(q) * q);
    }
    const RayCount ray = rays_.count(m, d, nullptr, skip);
    if (ray.status == RayStatus::starts_on_surface) return std::nullopt;
    if (ray.status != RayStatus::counted) continue;
    return Wedge{m.x, d.x, skip, ray.winding};
  }
  return std::nullopt;
}

std::vector<Wedge> Wedges::around(const Vec& u, const Point& m) const {
  std::vector<Wedge> out;
  const std::vector<Index> at = rays_.faces_at(m);
  if (at.empty()) return out;
  // Every face through m shows as one or two half-planes around u, or (with m on its edge across u) as
  // less. All directions n x u and -(n x u) are taken as borders: too many wedges do no harm.
  std::vector<Vec> borders;
  for (const Index f : at) {
    const Vec b = exact::cross(rays_.normal(f), u);
    if (exact::is_zero(b)) continue;
    const Vec scaled = inverse_length(b) * b;
    borders.push_back(scaled);
    borders.push_back(Rational(-1) * scaled);
  }
  if (borders.empty()) return out;
  const Vec first = borders[0], second = exact::cross(u, first);
  const auto half = [&](const Vec& v) {
    const int y = exact::sign(dot(second, v));
    return y > 0 || (y == 0 && exact::sign(dot(first, v)) > 0) ? 0 : 1;
  };
  std::sort(borders.begin(), borders.end(), [&](const Vec& x, const Vec& y) {
    const int hx = half(x), hy = half(y);
    if (hx != hy) return hx < hy;
    return exact::sign(exact::det(u, x, y)) > 0;
  });
  const Vec axis = inverse_length(u) * u;
  for (std::size_t i = 0; i < borders.size(); ++i) {
    const Vec &x = borders[i], &y = borders[(i + 1) % borders.size()];
    // Every border comes with its opposite, so a wedge is half a turn at most.
    const int turn = exact::sign(exact::det(u, x, y));
    if (turn < 0 || (turn == 0 && exact::sign(dot(x, y)) > 0)) continue;  // equal borders
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const double weight = 1 + 0.4 * exact::scatter(attempt);
      Vec d = turn == 0 ? exact::cross(axis, x) + Rational(weight - 1) * x : x + Rational(weight) * y;
      if (attempt > 0) d = d + Rational(0.3 * exact::scatter(attempt + 5)) * axis;
      // Doubles where the wedge is wide enough for them: short numbers are fast.
      const auto near = exact::approximate(d);
      const Vec rounded = exact::vec(near.data());
      const bool inside = turn == 0 ? exact::sign(exact::det(u, x, rounded)) > 0
                                    : exact::sign(exact::det(u, x, rounded)) > 0 &&
                                          exact::sign(exact::det(u, rounded, y)) > 0;
      if (inside) d = rounded;
      const RayCount ray = rays_.count(m, Point(d), nullptr, at);
      if (ray.status != RayStatus::counted) continue;
      out.push_back({m.x, d, at, ray.winding});
      break;
    }
  }
  return out;
}

}  // namespace overtet
