#include "src/mesh/subdivision.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>
#include <tuple>
#include <utility>

namespace overtet {

namespace {

using Weights = std::array<std::int64_t, 3>;

// Twice the area of a triangle in units of the grid; positive where it turns as the face does.
std::int64_t area(const Weights& a, const Weights& b, const Weights& c) {
  return (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
}
int side(const Weights& a, const Weights& b, const Weights& c) {
  const std::int64_t x = area(a, b, c);
  return (x > 0) - (x < 0);
}

// One face with its points. Local numbers: the corners, then the points.
class FaceTriangulation {
 public:
  // pre: at least one point.
  FaceTriangulation(const Surface& surface, Index f) {
    for (int k = 0; k < 3; ++k) {
      Weights corner{};
      corner[k] = kFaceGrid;
      add(surface.F(f, k), corner, surface.V.row(surface.F(f, k)));
    }
  }

  void add(Index id, const Weights& weight, const Eigen::Vector3d& position) {
    local_[id] = static_cast<int>(points_.size());
    points_.push_back({id, weight, position});
  }

  // False where the points coincide or the edges cross.
  bool run(const std::vector<FaceEdge>& edges, std::vector<std::array<Index, 3>>& out) {
    for (std::size_t i = 0; i < points_.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (points_[i].weight == points_[j].weight) return false;
    add_border();
    for (const FaceEdge& e : edges) {
      const auto a = local_.find(e.a), b = local_.find(e.b);
      if (a == local_.end() || b == local_.end()) return false;
      if (on_border(a->second, b->second)) continue;
      if (!fits(a->second, b->second)) return false;
      link(a->second, b->second);
    }
    fill();
    return collect(out);
  }

 private:
  struct Point {
    Index id;
    Weights weight;
    Eigen::Vector3d position;
  };
  const Weights& at(int i) const { return points_[i].weight; }
  int count() const { return static_cast<int>(points_.size()); }

  void link(int a, int b) {
    if (edges_.insert(std::minmax(a, b)).second) listed_.emplace_back(a, b);
  }
  bool linked(int a, int b) const { return edges_.count(std::minmax(a, b)) > 0; }

  // Both on one edge of the face.
  bool on_border(int a, int b) const {
    for (int k = 0; k < 3; ++k)
      if (at(a)[k] == 0 && at(b)[k] == 0) return true;
    return false;
  }

  void add_border() {
    for (int k = 0; k < 3; ++k) {
      std::vector<std::pair<std::int64_t, int>> along;
      for (int i = 0; i < count(); ++i)
        if (at(i)[k] == 0) along.emplace_back(at(i)[(k + 1) % 3], i);
      std::sort(along.begin(), along.end());
      for (std::size_t i = 1; i < along.size(); ++i) link(along[i - 1].second, along[i].second);
    }
  }

  // Whether an edge may be added: it crosses none and passes through no point. Most that do not fit cross
  // many, so few are looked at.
  bool fits(int a, int b) const {
    for (const auto& [c, d] : listed_) {
      if (c == a || c == b || d == a || d == b) continue;
      if (side(at(a), at(b), at(c)) * side(at(a), at(b), at(d)) < 0 &&
          side(at(c), at(d), at(a)) * side(at(c), at(d), at(b)) < 0)
        return false;
    }
    for (int c = 0; c < count(); ++c) {
      if (c == a || c == b || side(at(a), at(b), at(c)) != 0) continue;
      const auto between = [&](int k) {
        return std::min(at(a)[k], at(b)[k]) <= at(c)[k] && at(c)[k] <= std::max(at(a)[k], at(b)[k]);
      };
      if (between(0) && between(1) && between(2)) return false;
    }
    return true;
  }

  // The greedy triangulation: short edges first.
  void fill() {
    std::vector<std::tuple<double, int, int>> pairs;
    for (int b = 0; b < count(); ++b)
      for (int a = 0; a < b; ++a)
        if (!on_border(a, b) && !linked(a, b))
          pairs.emplace_back((points_[a].position - points_[b].position).squaredNorm(), a, b);
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [length, a, b] : pairs)
      if (fits(a, b)) link(a, b);
  }

  bool collect(std::vector<std::array<Index, 3>>& out) const {
    std::int64_t total = 0;
    for (int a = 0; a < count(); ++a)
      for (int b = a + 1; b < count(); ++b)
        for (int c = a + 1; c < count(); ++c) {
          if (c == b || !linked(a, b) || !linked(b, c) || !linked(c, a)) continue;
          if (side(at(a), at(b), at(c)) <= 0 || !empty(a, b, c)) continue;
          out.push_back({points_[a].id, points_[b].id, points_[c].id});
          total += area(at(a), at(b), at(c));
        }
    return total == kFaceGrid * kFaceGrid;
  }

  bool empty(int a, int b, int c) const {
    for (int d = 0; d < count(); ++d)
      if (d != a && d != b && d != c && side(at(a), at(b), at(d)) > 0 && side(at(b), at(c), at(d)) > 0 &&
          side(at(c), at(a), at(d)) > 0)
        return false;
    return true;
  }

  std::vector<Point> points_;
  std::map<Index, int> local_;
  std::set<std::pair<int, int>> edges_;
  std::vector<std::pair<int, int>> listed_;  // the same
};

}  // namespace

Eigen::Vector3d place_in_space(const Surface& surface, const FacePoint& point) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    p += static_cast<double>(point.weight[k]) / static_cast<double>(kFaceGrid) *
         surface.V.row(surface.F(point.face, k)).transpose();
  return p;
}

FacePoint seen_from_other_side(const SurfaceTopology& topology, const FacePoint& point) {
  const auto zero = std::find(point.weight.begin(), point.weight.end(), 0) - point.weight.begin();
  const int k = static_cast<int>(zero + 1) % 3;
  const Index other = topology.twin[3 * point.face + k];
  FacePoint out{other / 3, {}};
  out.weight[other % 3] = point.weight[(k + 1) % 3];
  out.weight[(other % 3 + 1) % 3] = point.weight[k];
  return out;
}

Result<Subdivision> subdivide(const Surface& surface, const SurfaceTopology& topology,
                              const std::vector<FacePoint>& points, const std::vector<FaceEdge>& edges) {
  const Index n = static_cast<Index>(surface.V.rows());
  Subdivision out;
  out.surface.V.resize(n + static_cast<Eigen::Index>(points.size()), 3);
  out.surface.V.topRows(n) = surface.V;
  std::map<Index, FaceTriangulation> cut;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Index id = n + static_cast<Index>(i);
    const Eigen::Vector3d position = place_in_space(surface, points[i]);
    out.surface.V.row(id) = position;
    const auto add = [&](const FacePoint& p) {
      cut.try_emplace(p.face, surface, p.face).first->second.add(id, p.weight, position);
    };
    add(points[i]);
    if (std::count(points[i].weight.begin(), points[i].weight.end(), 0) > 0)
      add(seen_from_other_side(topology, points[i]));
  }
  std::map<Index, std::vector<FaceEdge>> edges_of;
  for (const FaceEdge& e : edges) edges_of[e.face].push_back(e);
  std::vector<std::array<Index, 3>> faces;
  for (Index f = 0; f < surface.F.rows(); ++f) {
    const auto at = cut.find(f);
    if (at == cut.end()) {
      faces.push_back({surface.F(f, 0), surface.F(f, 1), surface.F(f, 2)});
    } else if (!at->second.run(edges_of[f], faces)) {
      return Error{ErrorCode::internal, "Face " + std::to_string(f) + " cannot be subdivided."};
    } else {
      out.pieced.push_back(f);
    }
    out.face.resize(faces.size(), f);
  }
  out.surface.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (int k = 0; k < 3; ++k) out.surface.F(static_cast<Eigen::Index>(i), k) = faces[i][k];
  return out;
}

}  // namespace overtet
