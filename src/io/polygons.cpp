#include <Eigen/Geometry>
#include <algorithm>

#include "src/io/surface_parts.h"
#include "src/io/tuning.h"

namespace overtet::io_detail {

namespace {

using Point2 = Eigen::Vector2d;

double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

// The smallest height of a triangle relative to its longest edge: 0 for a needle.
double shape(const Point2& a, const Point2& b, const Point2& c) {
  const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return longest > 0 ? turn(a, b, c) / longest : 0;
}

// Ear clipping in the plane of the polygon's Newell normal; the best shaped ear first. Where no ear is
// left (the polygon crosses itself or is flat), what remains is cut as a fan.
void cut_polygon(const VertexMatrix& V, std::span<const Index> corners, std::vector<Index>& triangles) {
  const std::size_t n = corners.size();
  const auto fan = [&](std::span<const std::size_t> ring) {
    for (std::size_t k = 1; k + 1 < ring.size(); ++k)
      for (const std::size_t r : {ring[0], ring[k], ring[k + 1]}) triangles.push_back(corners[r]);
  };
  std::vector<std::size_t> ring(n);
  for (std::size_t k = 0; k < n; ++k) ring[k] = k;
  if (n > kMaxEarCorners) return fan(ring);

  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  const Eigen::Vector3d origin = V.row(corners[0]);
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d a = V.row(corners[k]), b = V.row(corners[(k + 1) % n]);
    normal += (a - origin).cross(b - origin);
  }
  if (!(normal.norm() > 0)) return fan(ring);
  normal.normalize();
  const Eigen::Vector3d u = normal.unitOrthogonal(), w = normal.cross(u);
  std::vector<Point2> p(n);
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d d = V.row(corners[k]).transpose() - origin;
    p[k] = Point2(u.dot(d), w.dot(d));
  }
  while (ring.size() > 3) {
    const std::size_t m = ring.size();
    double best = 0;
    std::size_t ear = m;
    for (std::size_t k = 0; k < m; ++k) {
      const std::size_t a = ring[(k + m - 1) % m], b = ring[k], c = ring[(k + 1) % m];
      const double q = shape(p[a], p[b], p[c]);
      if (!(q > best)) continue;
      bool empty = true;
      for (const std::size_t x : ring) {
        if (x == a || x == b || x == c) continue;
        if (turn(p[a], p[b], p[x]) >= 0 && turn(p[b], p[c], p[x]) >= 0 && turn(p[c], p[a], p[x]) >= 0) {
          empty = false;
          break;
        }
      }
      if (!empty) continue;
      best = q, ear = k;
      if (m > kBestEarCorners) break;
    }
    if (ear == m) return fan(ring);
    for (const std::size_t r : {ring[(ear + m - 1) % m], ring[ear], ring[(ear + 1) % m]})
      triangles.push_back(corners[r]);
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  fan(ring);
}

}  // namespace

Surface triangulate(const Polygons& polygons, std::int64_t& cut, std::vector<Index>& face_of) {
  Surface s;
  s.V = Eigen::Map<const VertexMatrix>(polygons.xyz.data(),
                                       static_cast<Eigen::Index>(polygons.xyz.size() / 3), 3);
  cut = std::count_if(polygons.sizes.begin(), polygons.sizes.end(), [](Index n) { return n > 3; });
  if (cut == 0) {
    s.F = Eigen::Map<const TriangleMatrix>(polygons.corners.data(),
                                           static_cast<Eigen::Index>(polygons.sizes.size()), 3);
    return s;
  }
  std::vector<Index> triangles, ring, repeats;
  triangles.reserve(3 * (polygons.corners.size() - 2 * polygons.sizes.size()));
  face_of.reserve(polygons.corners.size() - 2 * polygons.sizes.size());
  std::size_t at = 0;
  for (std::size_t f = 0; f < polygons.sizes.size(); ++f) {
    const auto n = static_cast<std::size_t>(polygons.sizes[f]);
    const std::span<const Index> corners(&polygons.corners[at], n);
    at += n;
    face_of.insert(face_of.end(), n - 2, static_cast<Index>(f));
    if (n == 3) {
      triangles.insert(triangles.end(), corners.begin(), corners.end());
      continue;
    }
    ring.clear(), repeats.clear();
    for (std::size_t k = 0; k < n; ++k)
      (corners[k] == corners[(k + 1) % n] && repeats.size() + 3 < n ? repeats : ring).push_back(corners[k]);
    if (ring.size() == 3)
      triangles.insert(triangles.end(), ring.begin(), ring.end());
    else
      cut_polygon(s.V, ring, triangles);
    for (const Index v : repeats) triangles.insert(triangles.end(), {v, v, ring[0] == v ? ring[1] : ring[0]});
  }
  s.F =
      Eigen::Map<const TriangleMatrix>(triangles.data(), static_cast<Eigen::Index>(triangles.size() / 3), 3);
  return s;
}

}  // namespace overtet::io_detail
