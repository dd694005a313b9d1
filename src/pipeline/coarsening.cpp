#include "src/pipeline/coarsening.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "kernels/core/triangles.h"
#include "src/immersion/boundary_recovery.h"
#include "src/mesh/tet_complex.h"

namespace overtet {

namespace {

using Ends = std::pair<Index, Index>;

// The angle of a tet at its edge a-b, its other corners p and q.
double dihedral(const VertexMatrix& V, Index a, Index b, Index p, Index q) {
  const Eigen::Vector3d e = (V.row(b) - V.row(a)).transpose().normalized();
  const auto across = [&](Index i) {
    const Eigen::Vector3d d = (V.row(i) - V.row(a)).transpose();
    return Eigen::Vector3d(d - e * e.dot(d));
  };
  const Eigen::Vector3d u = across(p), w = across(q);
  return std::atan2(u.cross(w).norm(), u.dot(w));
}

// Of each point whether it is an end of one of the edges.
std::vector<char> ends_of(const std::vector<Ends>& edges, const MeshedSubdivision& made) {
  const Index first = made.mesh.surface_vertices - static_cast<Index>(made.points.size());
  std::vector<char> out(made.points.size(), 0);
  for (const auto& [a, b] : edges)
    for (const Index v : {a, b})
      if (v >= first) out[v - first] = 1;
  return out;
}

class Coarsening {
 public:
  Coarsening(const Surface& surface, const SurfaceTopology& topology, const MeshedSubdivision& made)
      : surface_(surface), topology_(topology), made_(made) {}

  // The points marked stay. Gives what becomes of it, or (in `left`) points that could not leave.
  std::optional<MeshedSubdivision> run(const std::vector<char>& stays, bool may_branch,
                                       const RunContext& context, std::vector<Index>& left) {
    const std::vector<Index> order = renumber(stays);
    Surface base = surface_;
    base.V.conservativeResize(vertices() + static_cast<Eigen::Index>(kept_.points.size()), 3);
    for (std::size_t i = 0; i < made_.points.size(); ++i)
      if (stays[i]) base.V.row(number_[i]) = made_.mesh.V.row(vertices() + static_cast<Index>(i));
    VertexMatrix V(made_.mesh.V.rows(), 3);
    TetMatrix T = made_.mesh.T;
    const auto renumbered = [&](Index v) {
      const Index p = v - vertices();
      return p >= 0 && p < static_cast<Index>(number_.size()) ? number_[p] : v;
    };
    for (Index v = 0; v < V.rows(); ++v) V.row(renumbered(v)) = made_.mesh.V.row(v);
    for (Index t = 0; t < T.rows(); ++t)
      for (int k = 0; k < 4; ++k) T(t, k) = renumbered(T(t, k));
    TetComplex complex(V, T);
    std::vector<std::array<Index, 3>> boundary;
    for (Index f = 0; f < made_.cut.surface.F.rows(); ++f) {
      std::array<Index, 3> corners;
      for (int k = 0; k < 3; ++k) corners[k] = renumbered(made_.cut.surface.F(f, k));
      boundary.push_back(corners);
    }
    BoundaryPointsOptions options;
    options.may_branch = may_branch;
    const BoundaryPointsResult cleared =
        clear_boundary_points(base, complex, boundary, made_.cut.face, context, options);
    for (const Index v : cleared.left) left.push_back(order[v - vertices()]);
    if (!left.empty()) return std::nullopt;
    const Index n = static_cast<Index>(base.V.rows());
    complex.compact(n);
    kept_.mesh = complex.to_mesh(n);
    kept_.cut.surface.V = std::move(base.V);
    take_faces(complex.boundary());
    return std::move(kept_);
  }

 private:
  Index vertices() const { return static_cast<Index>(surface_.V.rows()); }

  // Points that stay come first. Gives the old number of each.
  std::vector<Index> renumber(const std::vector<char>& stays) {
    std::vector<Index> order;
    number_.assign(stays.size(), -1);
    for (const bool kept : {true, false})
      for (std::size_t i = 0; i < stays.size(); ++i) {
        if ((stays[i] != 0) != kept) continue;
        number_[i] = vertices() + static_cast<Index>(order.size());
        order.push_back(static_cast<Index>(i));
        if (kept) kept_.points.push_back(made_.points[i]);
      }
    return order;
  }

  // The faces that a vertex of the boundary lies on.
  std::set<Index> faces_at(Index v) const {
    std::set<Index> out;
    if (v < vertices()) {
      for (const Index h : half_edges_around(topology_, v)) out.insert(h / 3);
      return out;
    }
    const FacePoint& p = kept_.points[v - vertices()];
    out.insert(p.face);
    if (std::count(p.weight.begin(), p.weight.end(), 0) > 0)
      out.insert(seen_from_other_side(topology_, p).face);
    return out;
  }

  void take_faces(const std::vector<std::array<Index, 3>>& boundary) {
    std::map<Index, std::vector<std::array<Index, 3>>> pieces;  // of faces that have added vertices
    std::set<std::array<Index, 3>> own;
    for (const std::array<Index, 3>& f : boundary)
      if (*std::max_element(f.begin(), f.end()) < vertices()) own.insert(rotated(f));
    std::vector<char> whole(static_cast<std::size_t>(surface_.F.rows()), 0);
    for (Index f = 0; f < surface_.F.rows(); ++f)
      whole[f] = own.erase(rotated(std::array{surface_.F(f, 0), surface_.F(f, 1), surface_.F(f, 2)})) > 0;
    for (std::array<Index, 3> f : boundary) {
      f = rotated(f);
      if (*std::max_element(f.begin(), f.end()) < vertices() && !own.count(f)) continue;
      // A triangle with an area lies on one face only.
      std::set<Index> common = faces_at(f[0]);
      for (int k = 1; k < 3; ++k) {
        const std::set<Index> here = faces_at(f[k]);
        std::erase_if(common, [&](Index g) { return !here.count(g); });
      }
      if (!common.empty()) pieces[*common.begin()].push_back(f);
    }
    std::vector<std::array<Index, 3>> faces;
    for (Index f = 0; f < surface_.F.rows(); ++f) {
      if (whole[f]) {
        faces.push_back({surface_.F(f, 0), surface_.F(f, 1), surface_.F(f, 2)});
      } else {
        std::vector<std::array<Index, 3>>& mine = pieces[f];
        std::sort(mine.begin(), mine.end());
        faces.insert(faces.end(), mine.begin(), mine.end());
        kept_.cut.pieced.push_back(f);
      }
      kept_.cut.face.resize(faces.size(), f);
    }
    kept_.cut.surface.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t i = 0; i < faces.size(); ++i)
      for (int k = 0; k < 3; ++k) kept_.cut.surface.F(static_cast<Eigen::Index>(i), k) = faces[i][k];
  }

  const Surface& surface_;
  const SurfaceTopology& topology_;
  const MeshedSubdivision& made_;
  std::vector<Index> number_;  // of each point
  MeshedSubdivision kept_;
};

}  // namespace

std::vector<Ends> wound_edges(const MeshedSubdivision& made) {
  const Index first = made.mesh.surface_vertices - static_cast<Index>(made.points.size());
  std::map<Ends, double> angle;
  for (Index f = 0; f < made.cut.surface.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Index a = made.cut.surface.F(f, k), b = made.cut.surface.F(f, (k + 1) % 3);
      if (std::max(a, b) >= first) angle.try_emplace(std::minmax(a, b), 0);
    }
  const TetMatrix& T = made.mesh.T;
  for (Index t = 0; t < T.rows(); ++t)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) {
        if (std::max(T(t, i), T(t, j)) < first) continue;
        const auto at = angle.find(std::minmax(T(t, i), T(t, j)));
        if (at == angle.end()) continue;
        const int p = i != 0 && j != 0 ? 0 : i != 1 && j != 1 ? 1 : 2;  // the other two: p, and what is left
        at->second += dihedral(made.mesh.V, T(t, i), T(t, j), T(t, p), T(t, 6 - i - j - p));
      }
  std::vector<Ends> out;
  for (const auto& [ends, total] : angle)
    if (total > 2 * M_PI) out.push_back(ends);  // more than a turn, which no surface shows
  return out;
}

Status drop_needless(const Surface& surface, const SurfaceTopology& topology, MeshedSubdivision& made,
                     const RunContext& context) {
  std::vector<char> stays = ends_of(wound_edges(made), made);
  for (;;) {
    std::vector<Index> left;
    auto coarse = Coarsening(surface, topology, made).run(stays, false, context, left);
    if (auto stop = context.stop()) return *stop;
    if (coarse) {
      made = std::move(*coarse);
      return success();
    }
    for (const Index p : left) stays[p] = 1;
  }
}

Result<bool> drop_all(const Surface& surface, const SurfaceTopology& topology, MeshedSubdivision& made,
                      const RunContext& context) {
  std::vector<Index> left;
  auto coarse =
      Coarsening(surface, topology, made).run(std::vector<char>(made.points.size(), 0), true, context, left);
  if (auto stop = context.stop()) return *stop;
  if (coarse) made = std::move(*coarse);
  return coarse.has_value();
}

}  // namespace overtet
