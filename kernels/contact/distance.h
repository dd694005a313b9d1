// Distances between the parts of triangles, the barrier on them, and steps that cannot pass through.
//
// A pair is four points: a vertex and a triangle (x0 | x1, x2, x3) or two edges (x0, x1 | x2, x3). Its
// closest points are affine combinations of the corners, so their difference is sum_i w_i x_i with
// sum_i w_i = 0; the distance is its length, and d distance / d x_i = w_i (difference / distance).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace overtet {

enum class PairKind { vertex_triangle, edge_edge };

struct Closest {
  std::array<double, 4> w{};   // coefficients of the difference
  Eigen::Vector3d difference;  // from the second part to the first
  double distance = 0;
};

// Any corners allowed, flat triangles and points as edges included.
Closest closest_points(PairKind kind, const std::array<Eigen::Vector3d, 4>& x);

// Barrier on the relative distance x = d / dhat in (0, 1): b = -(x - 1)^2 ln x, 0 from x = 1 on; twice
// continuously differentiable [Li et al. 2020].
inline double barrier(double x) { return x >= 1 ? 0.0 : -(x - 1) * (x - 1) * std::log(x); }
inline double barrier_slope(double x) {
  return x >= 1 ? 0.0 : -2 * (x - 1) * std::log(x) - (x - 1) * (x - 1) / x;
}
inline double barrier_curvature(double x) {
  return x >= 1 ? 0.0 : -2 * std::log(x) - 4 * (x - 1) / x + (x - 1) * (x - 1) / (x * x);
}

// The largest t in [0, 1] for which the two parts are certain to keep at least a tenth of their present
// distance on the whole way from x to x + t p (corners move on straight lines). Conservative: it may
// be smaller than the true time of impact, never larger. 0 where they touch already. Additive
// continuous collision detection [Li, Kaufman, Jiang 2021]: in time s the distance shrinks by at most s
// times the largest relative speed of the corners, their common motion taken away.
double safe_step(PairKind kind, const std::array<Eigen::Vector3d, 4>& x,
                 const std::array<Eigen::Vector3d, 4>& p);

}  // namespace overtet
