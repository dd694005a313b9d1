#include "src/mesh/thin_spots.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "kernels/core/union_find.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// Where a ray began, and what it met.
struct Wall {
  double thickness;
  Index face, across;
  Vector3d from;
};

class Walls {
 public:
  Walls(const Surface& s, const TriangleBvh& bvh, double limit, const std::vector<std::uint8_t>& crossing)
      : s_(s), bvh_(bvh), limit_(limit), crossing_(crossing), a_face_(s.V.rows(), -1) {
    normal_of_vertex_ = VertexMatrix::Zero(s.V.rows(), 3);
    for (Index f = static_cast<Index>(s.F.rows()); f-- > 0;)
      for (int k = 0; k < 3; ++k) {
        normal_of_vertex_.row(s.F(f, k)) += normal(f).transpose();
        a_face_[s.F(f, k)] = f;
      }
  }

  std::vector<Wall> find() const {
    return parallel_collect<Wall>(s_.F.rows() + s_.V.rows(), kMediumGrain,
                                  [&](std::int64_t begin, std::int64_t end, std::vector<Wall>& out) {
                                    for (std::int64_t i = begin; i < end; ++i) {
                                      const std::optional<Wall> wall =
                                          i < s_.F.rows() ? at_face(static_cast<Index>(i))
                                                          : at_vertex(static_cast<Index>(i - s_.F.rows()));
                                      if (wall) out.push_back(*wall);
                                    }
                                  });
  }

 private:
  Vector3d corner(Index f, int k) const { return s_.V.row(s_.F(f, k)).transpose(); }
  Vector3d normal(Index f) const { return (corner(f, 1) - corner(f, 0)).cross(corner(f, 2) - corner(f, 0)); }

  std::optional<Wall> at_face(Index f) const {
    const Vector3d from = (corner(f, 0) + corner(f, 1) + corner(f, 2)) / 3;
    return inwards(f, from, normal(f), [&](Index g) {
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          if (s_.F(f, i) == s_.F(g, j)) return true;
      return false;
    });
  }

  std::optional<Wall> at_vertex(Index v) const {
    if (a_face_[v] < 0) return std::nullopt;
    return inwards(a_face_[v], s_.V.row(v).transpose(), normal_of_vertex_.row(v).transpose(),
                   [&](Index g) { return s_.F(g, 0) == v || s_.F(g, 1) == v || s_.F(g, 2) == v; });
  }

  template <class Touches>
  std::optional<Wall> inwards(Index face, const Vector3d& from, const Vector3d& outwards,
                              const Touches& touches) const {
    const double length = outwards.norm();
    if (!(length > 0) || crossing_[face]) return std::nullopt;
    const Vector3d way = outwards * (-limit_ / length), to = from + way;
    const Vector3d low = from.cwiseMin(to), high = from.cwiseMax(to);
    double first = 1;  // of the way
    Index across = -1;
    bool leaves = false;
    bvh_.query_box(low.data(), high.data(), [&](Index g) {
      if (g == face || touches(g)) return;
      const std::optional<double> t = meets(from, way, g);
      // Of faces in one place the one with the smallest number counts, whatever the order of the search.
      if (!t || *t > first || (*t == first && across >= 0 && across < g)) return;
      first = *t;
      across = g;
      leaves = normal(g).dot(way) > 0;
    });
    if (across < 0 || !leaves || crossing_[across]) return std::nullopt;
    return Wall{first * limit_, face, across, from};
  }

  // How much of the way it is to the face [Moeller, Trumbore 1997].
  std::optional<double> meets(const Vector3d& from, const Vector3d& way, Index g) const {
    const Vector3d a = corner(g, 0), u = corner(g, 1) - a, w = corner(g, 2) - a, p = way.cross(w);
    const double det = u.dot(p);
    if (det == 0) return std::nullopt;
    const Vector3d s = from - a, q = s.cross(u);
    const double x = s.dot(p) / det, y = way.dot(q) / det, t = w.dot(q) / det;
    if (!(x >= 0 && y >= 0 && x + y <= 1 && t >= 0 && t <= 1)) return std::nullopt;
    return t;
  }

  const Surface& s_;
  const TriangleBvh& bvh_;
  double limit_;
  const std::vector<std::uint8_t>& crossing_;
  VertexMatrix normal_of_vertex_;
  std::vector<Index> a_face_;  // of each vertex, the first one
};

}  // namespace

std::vector<ThinSpot> find_thin_spots(const Surface& s, const TriangleBvh& bvh, double limit,
                                      const std::vector<std::uint8_t>& crossing) {
  const std::vector<Wall> walls = Walls(s, bvh, limit, crossing).find();
  UnionFind sets(static_cast<std::size_t>(s.F.rows()));
  std::vector<char> thin(s.F.rows(), 0);
  std::vector<Index> at(s.V.rows(), -1);  // a thin face of each vertex
  const auto add = [&](Index f) {
    thin[f] = 1;
    for (int k = 0; k < 3; ++k) {
      Index& other = at[s.F(f, k)];
      if (other >= 0) sets.join_smaller(f, other);
      other = f;
    }
  };
  for (const Wall& w : walls) {
    add(w.face);
    add(w.across);
    sets.join_smaller(w.face, w.across);
  }
  std::vector<Index> number(s.F.rows(), -1);  // of a root
  std::vector<ThinSpot> spots;
  for (const Wall& w : walls) {
    Index& n = number[sets.root(w.face)];
    if (n < 0) {
      n = static_cast<Index>(spots.size());
      spots.emplace_back();
      spots.back().thickness = w.thickness;
    } else if (w.thickness >= spots[n].thickness) {
      continue;
    }
    spots[n].thickness = w.thickness;
    spots[n].face = w.face;
    spots[n].across = w.across;
    spots[n].position = {w.from[0], w.from[1], w.from[2]};
  }
  for (Index f = 0; f < s.F.rows(); ++f)
    if (thin[f]) ++spots[number[sets.root(f)]].faces;
  std::stable_sort(spots.begin(), spots.end(),
                   [](const ThinSpot& a, const ThinSpot& b) { return a.thickness < b.thickness; });
  return spots;
}

}  // namespace overtet
