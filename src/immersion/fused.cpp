#include "src/immersion/fused.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "kernels/bvh/self_intersections.h"
#include "kernels/core/tet_tables.h"
#include "kernels/parallel/parallel.h"
#include "src/cdt/facets_on_faces.h"
#include "src/exact/winding.h"
#include "src/immersion/cell_mesh.h"

namespace overtet {

namespace {

using FacetOn = std::vector<std::array<Index, 4>>;

double volume(const TetgenResult& tets, Index t) {
  const Eigen::Vector3d a = tets.V.row(tets.T(t, 0)), b = tets.V.row(tets.T(t, 1)),
                        c = tets.V.row(tets.T(t, 2)), d = tets.V.row(tets.T(t, 3));
  return (b - a).cross(c - a).dot(d - a) / 6;
}

// Tets that no facet parts have the same winding number: the list of each such cell, its largest tets first.
std::vector<std::vector<Index>> cells_of(const TetgenResult& tets, const FacetOn& facet_on) {
  std::vector<std::vector<Index>> cells;
  std::vector<char> seen(static_cast<std::size_t>(tets.T.rows()), 0);
  for (Index seed = 0; seed < tets.T.rows(); ++seed) {
    if (seen[seed]) continue;
    std::vector<Index> cell{seed};
    seen[seed] = 1;
    for (std::size_t i = 0; i < cell.size(); ++i)
      for (int k = 0; k < 4; ++k) {
        const Index other = tets.neighbours(cell[i], k);
        if (other < 0 || facet_on[cell[i]][k] >= 0 || seen[other]) continue;
        seen[other] = 1;
        cell.push_back(other);
      }
    std::stable_sort(cell.begin(), cell.end(),
                     [&](Index a, Index b) { return volume(tets, a) > volume(tets, b); });
    cells.push_back(std::move(cell));
  }
  return cells;
}

// Rounding may have moved a small cell's tets onto the surface or out of the cell: the largest that is off it
// decides, and a cell without any does not count.
int winding_in(const std::vector<Index>& cell, const TetgenResult& tets, const WindingNumber& winding) {
  for (const Index t : cell) {
    const Eigen::RowVector3d p = (tets.V.row(tets.T(t, 0)) + tets.V.row(tets.T(t, 1)) +
                                  tets.V.row(tets.T(t, 2)) + tets.V.row(tets.T(t, 3))) /
                                 4;
    if (const std::optional<int> w = winding.at(p.data())) return *w;
  }
  return 0;
}

// The kept tets and their vertices, those of the boundary first.
class Fusing {
 public:
  Fusing(const CellMesh& cells, const FacetOn& facet_on, const std::vector<Index>& winding)
      : cells_(cells), tets_(cells.tets), facet_on_(facet_on), winding_(winding) {}

  FusedCells run() {
    number_vertices();
    FusedCells out;
    out.mesh.V.resize(vertices_, 3);
    out.mesh.surface_vertices = boundary_vertices_;
    for (Index v = 0; v < tets_.V.rows(); ++v)
      if (number_[v] >= 0) out.mesh.V.row(number_[v]) = tets_.V.row(v);
    Index kept = 0;
    for (Index t = 0; t < tets_.T.rows(); ++t) kept += covered(t);
    out.mesh.T.resize(kept, 4);
    kept = 0;
    for (Index t = 0; t < tets_.T.rows(); ++t) {
      if (!covered(t)) continue;
      for (int k = 0; k < 4; ++k) out.mesh.T(kept, k) = number_[tets_.T(t, k)];
      ++kept;
    }
    out.input_vertex.assign(static_cast<std::size_t>(vertices_), -1);
    const std::vector<Index>& place = cells_.arrangement.vertex_of_input;
    for (Index v = static_cast<Index>(place.size()) - 1; v >= 0; --v)
      if (const Index n = number_[place[v]]; n >= 0) out.input_vertex[n] = v;
    each_boundary_face([&](Index t, int k, std::array<Index, 3> face) {
      for (Index& v : face) v = number_[v];
      out.boundary.push_back(face);
      const Index triangle = tets_.facet_markers[facet_on_[t][k]] - 1;
      out.input_face.push_back(cells_.arrangement.sheets[cells_.arrangement.sheet_begin[triangle]].face);
    });
    return out;
  }

 private:
  bool covered(Index t) const { return t >= 0 && winding_[t] > 0; }

  template <class F>
  void each_boundary_face(F&& f) const {
    for (Index t = 0; t < tets_.T.rows(); ++t)
      for (int k = 0; k < 4; ++k)
        if (covered(t) && !covered(tets_.neighbours(t, k))) f(t, k, tet_face(tets_.T.row(t), k));
  }

  void number_vertices() {
    const Index unused = -1, inner = -2, boundary = -3;
    number_.assign(static_cast<std::size_t>(tets_.V.rows()), unused);
    for (Index t = 0; t < tets_.T.rows(); ++t)
      for (int k = 0; k < 4; ++k)
        if (covered(t)) number_[tets_.T(t, k)] = inner;
    each_boundary_face([&](Index, int, const std::array<Index, 3>& face) {
      for (const Index v : face) number_[v] = boundary;
    });
    for (Index& n : number_)
      if (n == boundary) n = vertices_++;
    boundary_vertices_ = vertices_;
    for (Index& n : number_)
      if (n == inner) n = vertices_++;
  }

  const CellMesh& cells_;
  const TetgenResult& tets_;
  const FacetOn& facet_on_;
  const std::vector<Index>& winding_;
  std::vector<Index> number_;  // of TetGen's vertices; negative: left out
  Index vertices_ = 0, boundary_vertices_ = 0;
};

Result<FusedCells> attempt(const Surface& surface, const std::vector<FacePair>& pairs, double tolerance,
                           const RunContext& context) {
  const Result<CellMesh> meshed = mesh_cells(surface, pairs, {.tolerance = tolerance}, context);
  if (!meshed) return meshed.error();
  const TetgenResult& tets = meshed.value().tets;
  context.report("immersion", 0.6, "winding numbers");
  const FacetOn facet_on = tets.facet_on.empty() ? facets_on_faces(tets) : tets.facet_on;
  const std::vector<std::vector<Index>> cells = cells_of(tets, facet_on);
  const WindingNumber number(surface);
  std::vector<Index> winding(static_cast<std::size_t>(tets.T.rows()), 0);
  parallel_for(static_cast<std::int64_t>(cells.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t c = begin; c < end && !context.stop(); ++c) {
      const int w = winding_in(cells[static_cast<std::size_t>(c)], tets, number);
      for (const Index t : cells[static_cast<std::size_t>(c)]) winding[t] = w;
    }
  });
  if (auto stop = context.stop()) return *stop;
  FusedCells out = Fusing(meshed.value(), facet_on, winding).run();
  if (out.mesh.T.rows() > 0) return out;
  return Error{ErrorCode::bad_input, "The surface winds around no place a positive number of times."};
}

}  // namespace

Result<FusedCells> fuse_cells(const Surface& surface, const std::vector<FacePair>& pairs,
                              const RunContext& context) {
  std::optional<Error> failure;
  for (const double tolerance : arrangement_tolerances(surface, pairs)) {
    Result<FusedCells> made = attempt(surface, pairs, tolerance, context);
    if (made || made.error().code != ErrorCode::unsolved) return made;
    if (!failure || tolerance == 0) failure = made.error();
  }
  return *failure;
}

}  // namespace overtet
