#include "kernels/contact/distance.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "kernels/contact/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// Parameter in [0, 1] of the point of a + t (b - a) next to p.
double parameter(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  if (!(length2 > 0)) return 0;
  return std::clamp(ab.dot(p - a) / length2, 0.0, 1.0);
}

void finish(Closest& c, const std::array<Vector3d, 4>& x) {
  // Relative to one corner: exact zeros stay zeros, and no digits are lost far from the origin.
  c.difference = c.w[1] * (x[1] - x[0]) + c.w[2] * (x[2] - x[0]) + c.w[3] * (x[3] - x[0]);
  c.distance = c.difference.norm();
}

Closest vertex_triangle(const std::array<Vector3d, 4>& x) {
  const Vector3d ab = x[2] - x[1], ac = x[3] - x[1], ap = x[0] - x[1];
  const Vector3d normal = ab.cross(ac);
  const double n2 = normal.squaredNorm();
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (x[3] - x[2]).squaredNorm()});
  Closest best;
  best.distance = std::numeric_limits<double>::infinity();
  // Inside the triangle's prism the foot of the perpendicular is the closest point.
  if (n2 > 0) {
    const double v = ap.cross(ac).dot(normal) / n2, w = ab.cross(ap).dot(normal) / n2, u = 1 - v - w;
    if (u >= 0 && v >= 0 && w >= 0) {
      best.w = {1, -u, -v, -w};
      finish(best, x);
      // For a needle u, v and w have lost their digits: its sides are looked at too.
      if (n2 > 1e-12 * longest * longest) return best;
    }
  }
  for (int k = 1; k <= 3; ++k) {
    const int a = k, b = k % 3 + 1;
    const double t = parameter(x[0], x[a], x[b]);
    Closest c;
    c.w[0] = 1;
    c.w[a] = -(1 - t);
    c.w[b] = -t;
    finish(c, x);
    if (c.distance < best.distance) best = c;
  }
  return best;
}

Closest edge_edge(const std::array<Vector3d, 4>& x) {
  const Vector3d d1 = x[1] - x[0], d2 = x[3] - x[2], r = x[0] - x[2];
  const double a = d1.squaredNorm(), e = d2.squaredNorm(), b = d1.dot(d2), c = d1.dot(r), f = d2.dot(r);
  const double denominator = a * e - b * b;
  Closest best;
  best.distance = std::numeric_limits<double>::infinity();
  if (denominator > 0) {
    const double s = (b * f - c * e) / denominator, t = (a * f - b * c) / denominator;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) {
      best.w = {1 - s, s, -(1 - t), -t};
      finish(best, x);
      if (denominator > 1e-10 * a * e) return best;  // else nearly parallel: the ends are as good
    }
  }
  for (int end = 0; end < 2; ++end) {
    {
      const double t = parameter(x[end], x[2], x[3]);
      Closest k;
      k.w = {end == 0 ? 1.0 : 0.0, end == 1 ? 1.0 : 0.0, -(1 - t), -t};
      finish(k, x);
      if (k.distance < best.distance) best = k;
    }
    {
      const double s = parameter(x[2 + end], x[0], x[1]);
      Closest k;
      k.w = {1 - s, s, end == 0 ? -1.0 : 0.0, end == 1 ? -1.0 : 0.0};
      finish(k, x);
      if (k.distance < best.distance) best = k;
    }
  }
  return best;
}

}  // namespace

Closest closest_points(PairKind kind, const std::array<Vector3d, 4>& x) {
  return kind == PairKind::vertex_triangle ? vertex_triangle(x) : edge_edge(x);
}

double safe_step(PairKind kind, const std::array<Vector3d, 4>& x_in, const std::array<Vector3d, 4>& p_in) {
  const Vector3d mean = 0.25 * (p_in[0] + p_in[1] + p_in[2] + p_in[3]);
  std::array<Vector3d, 4> x = x_in, p;
  for (int i = 0; i < 4; ++i) p[i] = p_in[i] - mean;
  const std::array<double, 4> speed = {p[0].norm(), p[1].norm(), p[2].norm(), p[3].norm()};
  const double approach = kind == PairKind::vertex_triangle
                              ? speed[0] + std::max({speed[1], speed[2], speed[3]})
                              : std::max(speed[0], speed[1]) + std::max(speed[2], speed[3]);
  if (!(approach > 0)) return 1;
  const double start = closest_points(kind, x).distance;
  if (!(start > 0)) return 0;
  if (approach <= (1 - kKeep) * start) return 1;
  const double keep = kKeep * start;
  double t = 0, distance = start;
  for (int step = 0; step < kAdvances; ++step) {
    const double room = distance - keep;
    if (room < 0.01 * keep) break;
    t += room / approach;
    if (t >= 1) return 1;
    for (int i = 0; i < 4; ++i) x[i] = x_in[i] + t * p[i];
    distance = closest_points(kind, x).distance;
  }
  return t;
}

}  // namespace overtet
