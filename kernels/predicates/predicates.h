// Exact decisions on the very doubles they are given.
//
// Guaranteed:
//  1. The answer is that of real arithmetic on the given numbers, whatever they are (finite), overflow and
//     underflow included. Nothing is rounded, nothing is "almost".
//  2. orient3d and orient2d change sign when two of their points are swapped, so all callers that see
//     the same points agree.
//  3. Pure functions of their arguments: safe from several threads, same answer everywhere.
//
// How: a semi-static floating-point filter (inline), then a filter with the permanent as error bound, then
// whole numbers of 192 bits where the coordinates are of similar size, else expansion arithmetic on the stack
// (Shewchuk 1997), then, for coordinates whose products could leave the range of doubles, rationals. Only the
// last one allocates; in a unit box it needs coordinate differences below 1e-90.
//
// pre: every coordinate is finite; where one is not the answer means nothing, but there is one. Points are
// three (two) consecutive doubles.
#pragma once

#include <algorithm>
#include <cmath>

#include "overtet/types.h"

namespace overtet {

namespace predicates_detail {
int orient3d_slow(const double* a, const double* b, const double* c, const double* d);
int orient2d_slow(double ax, double ay, double bx, double by, double cx, double cy);
inline double max3(double a, double b, double c) { return std::max(std::max(a, b), c); }
}  // namespace predicates_detail

// The sign (-1, 0, 1) of det(b - a, c - a, d - a): 1 when d is on the side from which a, b, c turn
// counter-clockwise.
inline int orient3d(const double* a, const double* b, const double* c, const double* d) {
  using predicates_detail::max3;
  const double bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
  const double cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
  const double dx = d[0] - a[0], dy = d[1] - a[1], dz = d[2] - a[2];
  const double det = (bx * cy - by * cx) * dz + (by * cz - bz * cy) * dx + (bz * cx - bx * cz) * dy;
  const double mx = max3(std::fabs(bx), std::fabs(cx), std::fabs(dx));
  const double my = max3(std::fabs(by), std::fabs(cy), std::fabs(dy));
  const double mz = max3(std::fabs(bz), std::fabs(cz), std::fabs(dz));
  // 5.12e-15: the rounding of differences, products and sums, 46 ulp of the largest possible product
  // (the constant of Meyer and Pion 2008). Within the two limits nothing overflows or loses bits below.
  const double low = std::min(std::min(mx, my), mz), high = max3(mx, my, mz);
  if (low >= 1e-97 && high <= 1e102) {
    const double bound = 5.12e-15 * mx * my * mz;
    if (det > bound) return 1;
    if (det < -bound) return -1;
  } else if (low == 0) {
    return 0;  // all four in an axis-parallel plane
  }
  return predicates_detail::orient3d_slow(a, b, c, d);
}

// The sign of (b - a) x (c - a) in the plane: 1 when a, b, c turn counter-clockwise.
inline int orient2d(double ax, double ay, double bx, double by, double cx, double cy) {
  const double px = bx - ax, py = by - ay, qx = cx - ax, qy = cy - ay;
  const double left = px * qy, right = py * qx, det = left - right;
  // 4 ulp of the sum of the two products; below 1e-280 a product may have lost bits.
  const double bound = 4.5e-16 * (std::fabs(left) + std::fabs(right));
  if (bound >= 1e-290 && bound <= 1e280) {
    if (det > bound) return 1;
    if (det < -bound) return -1;
  }
  return predicates_detail::orient2d_slow(ax, ay, bx, by, cx, cy);
}
inline int orient2d(const double* a, const double* b, const double* c) {
  return orient2d(a[0], a[1], b[0], b[1], c[0], c[1]);
}

// True when a, b and c lie on one line (the triangle has no area).
bool collinear(const double* a, const double* b, const double* c);

// True when the closed segment pq and the closed triangle abc have a common point. Flat ones allowed.
bool segment_triangle_intersect(const double* p, const double* q, const double* a, const double* b,
                                const double* c);

// Two triangles that share no vertex: a common point anywhere. Triangles without area count as the
// segment or point they are.
bool triangles_intersect(const double* a0, const double* a1, const double* a2, const double* b0,
                         const double* b1, const double* b2);

// Triangles (v, a, b) and (v, c, d): a common point other than v.
bool triangles_intersect_beyond_vertex(const double* v, const double* a, const double* b, const double* c,
                                       const double* d);

// Triangles on the common edge ab with third corners c and d: they overlap, which means coplanar and on
// the same side of the edge.
bool triangles_overlap_at_edge(const double* a, const double* b, const double* c, const double* d);

// The question for two faces given by vertex numbers, by what they share: nothing, one vertex, an edge;
// faces with the same three vertices always intersect. The meaning is that of
// CGAL::Polygon_mesh_processing::self_intersections. V: rows of three doubles; f, g: three indices.
bool faces_intersect(const double* V, const Index* f, const Index* g);

}  // namespace overtet
