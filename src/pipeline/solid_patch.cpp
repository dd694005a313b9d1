#include "src/pipeline/solid_patch.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "src/mesh/tet_complex.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using Face = std::array<Index, 3>;

// Vertices at which closed faces are pinched: of edges with more than two faces, and those with more than one
// fan. Sorted.
std::vector<Index> pinched_at(const std::vector<Face>& faces) {
  struct Side {
    Index a, b, face;  // an edge, a < b
    bool operator<(const Side& s) const { return a != s.a ? a < s.a : b != s.b ? b < s.b : face < s.face; }
  };
  std::vector<Side> sides;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(faces[f][k], faces[f][(k + 1) % 3]);
      sides.push_back({a, b, static_cast<Index>(f)});
    }
  std::sort(sides.begin(), sides.end());
  // Fans: corners that hang together over edges of two faces. Corner 3 f + k is that of vertex faces[f][k].
  UnionFind fans(3 * faces.size());
  const auto corner = [&](Index face, Index v) {
    const Face& f = faces[static_cast<std::size_t>(face)];
    return 3 * face + (f[0] == v ? 0 : f[1] == v ? 1 : 2);
  };
  std::vector<Index> pinched;
  for (std::size_t i = 0, j = 0; i < sides.size(); i = j) {
    while (j < sides.size() && sides[j].a == sides[i].a && sides[j].b == sides[i].b) ++j;
    if (j - i != 2) {
      pinched.insert(pinched.end(), {sides[i].a, sides[i].b});
      continue;
    }
    for (const Index v : {sides[i].a, sides[i].b})
      fans.join(corner(sides[i].face, v), corner(sides[i + 1].face, v));
  }
  std::vector<std::array<Index, 2>> fan_of;  // vertex, fan
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t k = 0; k < 3; ++k)
      fan_of.push_back({faces[f][k], fans.root(static_cast<Index>(3 * f + k))});
  std::sort(fan_of.begin(), fan_of.end());
  for (std::size_t i = 1; i < fan_of.size(); ++i)
    if (fan_of[i][0] == fan_of[i - 1][0] && fan_of[i][1] != fan_of[i - 1][1]) pinched.push_back(fan_of[i][0]);
  std::sort(pinched.begin(), pinched.end());
  pinched.erase(std::unique(pinched.begin(), pinched.end()), pinched.end());
  return pinched;
}

// Tets of a mesh that are to be cut out of it.
class Cutter {
 public:
  Cutter(const TetMesh& mesh, const VertexMatrix& target)
      : mesh_(mesh),
        target_(target),
        complex_(mesh.V, mesh.T),
        in_(static_cast<std::size_t>(mesh.T.rows()), 0) {}

  bool has(Index t) const { return in_[static_cast<std::size_t>(t)] != 0; }
  void add_all() { std::fill(in_.begin(), in_.end(), char{1}); }

  // All tets at a seed; returns their corners.
  std::vector<Index> add_stars(const std::vector<Index>& seeds) {
    std::vector<Index> star, corners;
    for (const Index v : seeds) {
      complex_.star(v, star);
      for (const Index t : star) {
        if (has(t)) continue;
        in_[static_cast<std::size_t>(t)] = 1;
        for (const Index c : complex_.tet(t)) corners.push_back(c);
      }
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    return corners;
  }

  // What hangs on nothing but the patch: it has no face of the surface, so it would stay where it is while
  // all around it moves.
  void add_enclosed() {
    const Index n = complex_.tet_capacity();
    UnionFind parts(static_cast<std::size_t>(n));
    for (Index t = 0; t < n; ++t)
      for (int k = 0; k < 4; ++k)
        if (const Index o = complex_.neighbour(t, k); o > t && !has(t) && !has(o)) parts.join(t, o);
    std::vector<char> at_surface(static_cast<std::size_t>(n), 0);
    for (Index t = 0; t < n; ++t)
      for (int k = 0; k < 4; ++k)
        if (complex_.neighbour(t, k) < 0) at_surface[static_cast<std::size_t>(parts.root(t))] = 1;
    for (Index t = 0; t < n; ++t)
      if (!at_surface[static_cast<std::size_t>(parts.root(t))]) in_[static_cast<std::size_t>(t)] = 1;
  }

  // Of the patch, outward.
  std::vector<Face> faces() const {
    std::vector<Face> out;
    for (Index t = 0; t < complex_.tet_capacity(); ++t)
      for (int k = 0; k < 4 && has(t); ++k)
        if (const Index o = complex_.neighbour(t, k); o < 0 || !has(o))
          out.push_back(tet_face(complex_.tet(t), k));
    return out;
  }

  SolidPatch patch(const std::vector<Face>& faces) const {
    SolidPatch out;
    for (Index t = 0; t < complex_.tet_capacity(); ++t)
      if (has(t)) out.tets.push_back(t);
    // Numbers: the boundary's vertices first, all in their order.
    enum : char { unused, inside, boundary };
    std::vector<char> kind(static_cast<std::size_t>(mesh_.V.rows()), unused);
    for (const Index t : out.tets)
      for (const Index v : complex_.tet(t)) kind[static_cast<std::size_t>(v)] = inside;
    for (const Face& f : faces)
      for (const Index v : f) kind[static_cast<std::size_t>(v)] = boundary;
    std::vector<Index> number(kind.size(), -1);
    for (const char wanted : {boundary, inside}) {
      for (std::size_t v = 0; v < kind.size(); ++v)
        if (kind[v] == wanted) {
          number[v] = static_cast<Index>(out.vertices.size());
          out.vertices.push_back(static_cast<Index>(v));
        }
      if (wanted == boundary) out.start.surface_vertices = static_cast<Index>(out.vertices.size());
    }
    out.start.V.resize(static_cast<Eigen::Index>(out.vertices.size()), 3);
    for (std::size_t i = 0; i < out.vertices.size(); ++i)
      out.start.V.row(static_cast<Eigen::Index>(i)) = mesh_.V.row(out.vertices[i]);
    out.start.T.resize(static_cast<Eigen::Index>(out.tets.size()), 4);
    for (std::size_t i = 0; i < out.tets.size(); ++i)
      for (int k = 0; k < 4; ++k)
        out.start.T(static_cast<Eigen::Index>(i), k) =
            number[static_cast<std::size_t>(mesh_.T(out.tets[i], k))];
    out.target.V = out.start.V.topRows(out.start.surface_vertices);
    for (Index i = 0; i < out.start.surface_vertices; ++i)
      if (const Index v = out.vertices[static_cast<std::size_t>(i)]; v < target_.rows())
        out.target.V.row(i) = target_.row(v);
    out.target.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (std::size_t k = 0; k < 3; ++k)
        out.target.F(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(k)) =
            number[static_cast<std::size_t>(faces[f][k])];
    return out;
  }

 private:
  const TetMesh& mesh_;
  const VertexMatrix& target_;
  const TetComplex complex_;
  std::vector<char> in_;
};

}  // namespace

SolidPatch solid_around(const TetMesh& mesh, const VertexMatrix& target, const std::vector<Index>& away,
                        int rings) {
  OVERTET_EXPECTS(target.rows() == mesh.surface_vertices && rings > 0);
  Cutter cutter(mesh, target);
  std::vector<Index> seeds = away;
  for (int ring = 0; ring < rings; ++ring) seeds = cutter.add_stars(seeds);
  for (int mend = 0; mend < kMostRounds; ++mend) {
    cutter.add_enclosed();
    const std::vector<Face> faces = cutter.faces();
    const std::vector<Index> pinched = pinched_at(faces);
    if (pinched.empty()) {
      SolidPatch patch = cutter.patch(faces);
      if (require_topology(patch.target)) return patch;
      break;
    }
    cutter.add_stars(pinched);
  }
  cutter.add_all();
  return cutter.patch(cutter.faces());
}

Draft glued(const TetMesh& mesh, const VertexMatrix& target, const SolidPatch& patch, const Draft& inside) {
  const Index surface = mesh.surface_vertices, own = patch.start.surface_vertices;
  OVERTET_EXPECTS(target.rows() == surface && inside.mesh.surface_vertices == own);
  const auto n = static_cast<std::size_t>(mesh.T.rows());
  std::vector<char> out(n, 0);
  for (const Index t : patch.tets) out[static_cast<std::size_t>(t)] = 1;
  // Vertices inside that stay: of tets that stay, which includes those of the cut.
  std::vector<Index> number(static_cast<std::size_t>(mesh.V.rows()), -1);
  for (Index v = 0; v < surface; ++v) number[static_cast<std::size_t>(v)] = v;
  for (std::size_t t = 0; t < n; ++t)
    for (int k = 0; k < 4 && !out[t]; ++k) {
      const Index v = mesh.T(static_cast<Eigen::Index>(t), k);
      if (v >= surface) number[static_cast<std::size_t>(v)] = 0;
    }
  Index next = surface + inside.placed;
  for (std::size_t v = static_cast<std::size_t>(surface); v < number.size(); ++v)
    if (number[v] == 0) number[v] = next++;
  const Index others = static_cast<Index>(inside.mesh.V.rows()) - own - inside.placed;

  Draft whole;
  whole.placed = next - surface;
  whole.mesh.surface_vertices = surface;
  whole.mesh.V.resize(next + others, 3);
  whole.mesh.V.topRows(surface) = target;
  whole.mesh.V.middleRows(surface, inside.placed) = inside.mesh.V.middleRows(own, inside.placed);
  for (std::size_t v = static_cast<std::size_t>(surface); v < number.size(); ++v)
    if (number[v] >= 0) whole.mesh.V.row(number[v]) = mesh.V.row(static_cast<Eigen::Index>(v));
  whole.mesh.V.bottomRows(others) = inside.mesh.V.bottomRows(others);

  whole.mesh.T.resize(mesh.T.rows() - static_cast<Eigen::Index>(patch.tets.size()) + inside.mesh.T.rows(), 4);
  Eigen::Index made = 0;
  for (std::size_t t = 0; t < n; ++t) {
    if (out[t]) continue;
    for (int k = 0; k < 4; ++k)
      whole.mesh.T(made, k) = number[static_cast<std::size_t>(mesh.T(static_cast<Eigen::Index>(t), k))];
    ++made;
  }
  for (Eigen::Index t = 0; t < inside.mesh.T.rows(); ++t, ++made)
    for (int k = 0; k < 4; ++k) {
      const Index v = inside.mesh.T(t, k);
      whole.mesh.T(made, k) =
          v < own ? number[static_cast<std::size_t>(patch.vertices[static_cast<std::size_t>(v)])]
          : v < own + inside.placed ? surface + v - own
                                    : next + v - own - inside.placed;
    }
  return whole;
}

}  // namespace overtet
