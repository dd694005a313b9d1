#include "src/prepare/joining.h"

#include <algorithm>
#include <unordered_set>

#include "kernels/bvh/box_tree.h"
#include "kernels/near_points/near_points.h"
#include "kernels/parallel/tuning.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

std::vector<Index> border_vertices(const TriangleMatrix& F, const std::vector<Index>& border) {
  std::vector<Index> vertices;
  for (const Index h : border) {
    vertices.push_back(half_edge_source(F, h));
    vertices.push_back(half_edge_target(F, h));
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

std::vector<Index> border_of(const Surface& s) {
  return border_half_edges(s.F, Incidence(static_cast<Index>(s.V.rows()), s.F));
}

// A vertex beside an edge.
struct Beside {
  double along;  // the edge, 0 to 1
  Index vertex;
  auto operator<=>(const Beside&) const = default;
};

// The vertices beside each border edge, in the order along it.
std::vector<std::vector<Beside>> vertices_beside(const Surface& s, const std::vector<Index>& border,
                                                 double distance) {
  const std::vector<Index> vertices = border_vertices(s.F, border);
  const auto point = [&](Index v) { return Eigen::Vector3d(s.V.row(v)); };
  BoxTree tree;
  tree.build(static_cast<Index>(border.size()), [&](Index i) {
    const Eigen::Vector3d a = point(half_edge_source(s.F, border[i])),
                          b = point(half_edge_target(s.F, border[i]));
    Box box;
    for (int k = 0; k < 3; ++k) box.low[k] = std::min(a[k], b[k]), box.high[k] = std::max(a[k], b[k]);
    box.grow(distance);
    return box;
  });
  std::vector<std::vector<Beside>> beside(border.size());
  for (const Index v : vertices) {
    const Eigen::Vector3d p = point(v);
    tree.query_box(p.data(), p.data(), [&](Index i) {
      const Index from = half_edge_source(s.F, border[i]), to = half_edge_target(s.F, border[i]);
      const Eigen::Vector3d a = point(from), b = point(to), way = b - a;
      // What lies where an end does belongs to the end, and the face's own corner would leave it no area.
      if (p == a || p == b || v == half_edge_opposite(s.F, border[i])) return;
      const double t = (p - a).dot(way) / way.squaredNorm();
      if (!(t > 0 && t < 1)) return;
      if ((a + t * way - p).norm() <= distance) beside[i].push_back({t, v});
    });
  }
  for (std::vector<Beside>& list : beside) std::sort(list.begin(), list.end());
  return beside;
}

}  // namespace

Result<Joined> put_together(WorkingSurface& working, double distance, const RunContext& context) {
  Surface& s = working.surface;
  const std::vector<Index> vertices = border_vertices(s.F, border_of(s));
  VertexMatrix points(static_cast<Index>(vertices.size()), 3);
  for (std::size_t i = 0; i < vertices.size(); ++i) points.row(static_cast<Index>(i)) = s.V.row(vertices[i]);
  Joined out;
  if (vertices.empty()) return out;
  const NearPoints near(points);
  std::vector<char> taken(vertices.size(), 0);
  std::vector<Index> found;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (i % kLightGrain == 0)
      if (auto stop = context.stop()) return *stop;
    if (taken[i]) continue;
    taken[i] = 1;
    const Eigen::Vector3d p = points.row(static_cast<Index>(i));
    near.within(p, distance, found);
    for (const Index j : found) {
      if (taken[j]) continue;
      taken[j] = 1;
      const Eigen::Vector3d q = points.row(j);
      if (q != p) out.moved.emplace_back(vertices[j], q);
      s.V.row(vertices[j]) = p.transpose();
    }
  }
  std::sort(out.moved.begin(), out.moved.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  return out;
}

std::int64_t split_at_vertices(WorkingSurface& working, double distance) {
  Surface& s = working.surface;
  const std::vector<Index> border = border_of(s);
  const std::vector<std::vector<Beside>> beside = vertices_beside(s, border, distance);
  std::int64_t split = 0;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<Index, 3>> faces;  // behind those that are there
  std::vector<Index> face_of;
  const Index vertices = static_cast<Index>(s.V.rows());
  // The edges of a face one after the other: half-edges come in ascending order. What is left of the face
  // keeps its number and the edges that are still to come.
  for (std::size_t i = 0; i < border.size(); ++i) {
    const Index f = half_edge_face(border[i]);
    const int k = border[i] % 3;
    // Of a triangle by itself whose three edges are to be split the third one is not there any more.
    if (beside[i].empty() || s.F(f, (k + 1) % 3) >= vertices) continue;
    ++split;
    const Index far = s.F(f, (k + 2) % 3), to = s.F(f, (k + 1) % 3);
    // The next edge, if it is to be split, begins where the last piece is; the one after it ends at the
    // first.
    const bool keep_last =
        i + 1 < border.size() && border[i + 1] == 3 * f + k + 1 && k < 2 && !beside[i + 1].empty();
    Index from = s.F(f, k);
    std::vector<Index> chain{from};
    for (const Beside& b : beside[i]) {
      points.emplace_back(s.V.row(b.vertex));
      chain.push_back(vertices + static_cast<Index>(points.size()) - 1);
    }
    chain.push_back(to);
    const std::size_t kept = keep_last ? chain.size() - 2 : 0;
    for (std::size_t j = 0; j + 1 < chain.size(); ++j) {
      if (j == kept) continue;
      faces.push_back({chain[j], chain[j + 1], far});
      face_of.push_back(working.face_of[f]);
    }
    s.F(f, k) = chain[kept];
    s.F(f, (k + 1) % 3) = chain[kept + 1];
  }
  const Index n = static_cast<Index>(s.F.rows());
  s.V.conservativeResize(vertices + static_cast<Index>(points.size()), 3);
  s.F.conservativeResize(n + static_cast<Index>(faces.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    s.V.row(vertices + static_cast<Index>(i)) = points[i].transpose();
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (int k = 0; k < 3; ++k) s.F(n + static_cast<Index>(i), k) = faces[i][k];
  working.vertex_of.resize(s.V.rows(), -1);
  working.face_of.insert(working.face_of.end(), face_of.begin(), face_of.end());
  return split;
}

std::int64_t put_back(const Joined& joined, const Cleanup& cleaned, Surface& surface) {
  std::unordered_set<Index> merged;
  for (const auto& [given, became] : cleaned.merged) merged.insert(became);
  const auto came_from = [&](Index v) { return cleaned.vertex_of.empty() ? v : cleaned.vertex_of[v]; };
  for (Index v = 0; v < surface.V.rows() && !joined.moved.empty(); ++v) {
    const auto at = std::lower_bound(joined.moved.begin(), joined.moved.end(), came_from(v),
                                     [](const auto& m, Index u) { return m.first < u; });
    if (at != joined.moved.end() && at->first == came_from(v) && !merged.contains(v))
      surface.V.row(v) = at->second.transpose();
  }
  return static_cast<std::int64_t>(cleaned.merged.size());
}

}  // namespace overtet
