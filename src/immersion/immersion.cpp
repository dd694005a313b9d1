#include "src/immersion/immersion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "src/immersion/boundary_recovery.h"
#include "src/immersion/cell_mesh.h"
#include "src/immersion/covering_complex.h"
#include "src/immersion/sheets.h"
#include "src/immersion/tuning.h"
#include "src/mesh/tet_complex.h"

namespace overtet {

namespace {

class Laps {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

Status ImmersionOptions::validate() const {
  if (radius_edge != 0 && !(radius_edge >= 1.2 && radius_edge <= 100))
    return Error{ErrorCode::usage, "The radius-edge bound must lie between 1.2 and 100, or be 0 for none."};
  return success();
}

namespace {

// Of the points that cutting added, all are moved inside. Errors: unsolved, limit, interrupted.
Status clear_boundary(const Surface& surface, const Cover& cover, const RunContext& context,
                      TetComplex& complex, ImmersionResult& out) {
  const BoundaryPointsResult cleared =
      clear_boundary_points(surface, complex, cover.boundary, cover.face, context);
  out.boundary_points = cleared.removed;
  out.refined_edges = cleared.refined_edges;
  out.smallest_clearance = cleared.smallest_clearance;
  if (auto stop = context.stop()) return *stop;
  if (cleared.left.empty()) return success();
  const Eigen::Vector3d p = complex.position(cleared.left[0]);
  return Error{ErrorCode::unsolved,
               std::to_string(cleared.left.size()) +
                   " points where the surface crosses itself could not be moved inside.",
               std::array<double, 3>{p[0], p[1], p[2]}};
}

// The surface's vertices, where a tolerance has moved them. Errors: unsolved, limit, interrupted.
Status return_home(const Surface& surface, const RunContext& context, TetComplex& complex) {
  const std::vector<Index> away = bring_home(surface, complex, context);
  if (auto stop = context.stop()) return *stop;
  if (away.empty()) return success();
  const auto p = surface.V.row(away[0]);
  return Error{ErrorCode::unsolved,
               std::to_string(away.size()) +
                   " vertices that nearly touch other parts of the surface could not return to their places.",
               std::array<double, 3>{p[0], p[1], p[2]}};
}

struct Realised {
  bool glued = false;
  std::optional<Error> failure;
};

// Glues the cells of out.arrangement and makes a mesh of them.
Realised realise(const Surface& surface, const TetgenResult& tets, std::span<const WoundEdge> wound,
                 int variant, Laps& watch, const RunContext& context, ImmersionResult& out) {
  Result<Sheets> sheets = assign_sheets(surface, out.arrangement, tets, wound, variant, context);
  if (!sheets) return {false, sheets.error()};
  out.cells = static_cast<Index>(sheets.value().winding.size());
  out.regions = static_cast<Index>(sheets.value().regions.size());
  out.constraints = sheets.value().constraints;
  out.search_nodes += sheets.value().search_nodes;
  for (const Index w : sheets.value().winding) out.winding_max = std::max(out.winding_max, w);
  Result<Cover> cover = build_cover(surface, out.arrangement, tets, sheets.value(), context);
  if (!cover) return {false, cover.error()};
  out.sheets_seconds += watch.lap();

  context.report("immersion", 0.8, "boundary points");
  TetComplex complex(cover.value().mesh.V, cover.value().mesh.T, cover.value().neighbours);
  const Status cleared = clear_boundary(surface, cover.value(), context, complex, out);
  const Index free_points = cover.value().free_points;
  out.cover = std::move(cover).value().mesh;
  out.boundary_seconds += watch.lap();
  if (!cleared) return {true, cleared.error()};
  if (out.arrangement.tolerant)
    if (Status home = return_home(surface, context, complex); !home) return {true, home.error()};
  const Index n = static_cast<Index>(surface.V.rows());
  out.free_points = 0;
  for (Index v = n; v < n + free_points; ++v) out.free_points += complex.tet_of(v) >= 0;
  complex.compact(n);
  out.mesh = complex.to_mesh(n);
  return {true, std::nullopt};
}

// tolerance: of the arrangement; 0: exact.
Result<ImmersionResult> attempt(const Surface& surface, const std::vector<FacePair>& pairs,
                                std::span<const WoundEdge> wound, const ImmersionOptions& options,
                                double tolerance, const RunContext& context) {
  ImmersionResult out;
  Laps watch;
  Result<CellMesh> cells =
      mesh_cells(surface, pairs, {options.radius_edge, options.patience, tolerance}, context);
  if (!cells) return cells.error();
  out.arrangement = std::move(cells.value().arrangement);
  out.arrangement_seconds = cells.value().arrangement_seconds;
  const TetgenResult& tets = cells.value().tets;
  out.tet_mesh_seconds = cells.value().tet_mesh_seconds;
  watch.lap();
  out.steiner_points = static_cast<Index>(tets.V.rows() - out.arrangement.V.rows()) - tets.free_points;
  out.missing_facets = tets.missing_facets;
  out.tetgen_facets = tets.tetgen_facets;
  out.tetgen_parts = tets.parts;

  context.report("immersion", 0.6, "gluing");
  // Where points cannot leave the boundary of one solution, they may be able to leave that of another one.
  std::optional<Error> failure;
  for (int variant = 0; variant < kInVain; ++variant) {
    const Realised done = realise(surface, tets, wound, variant, watch, context, out);
    if (!done.failure) return out;
    if (!failure || done.failure->code != ErrorCode::unsolved) failure = done.failure;
    if (failure->code != ErrorCode::unsolved || !done.glued) break;
  }
  return *failure;
}

}  // namespace

Result<ImmersionResult> immerse(const Surface& surface, const std::vector<FacePair>& pairs,
                                std::span<const WoundEdge> wound, const ImmersionOptions& options,
                                const RunContext& context) {
  if (Status valid = options.validate(); !valid) return valid.error();
  std::optional<Error> failure;
  for (const double tolerance : arrangement_tolerances(surface, pairs)) {
    Result<ImmersionResult> result = attempt(surface, pairs, wound, options, tolerance, context);
    if (result || result.error().code != ErrorCode::unsolved) return result;
    Error error = result.error();
    // Only without a tolerance is it the surface itself that has been tried.
    if (tolerance > 0) error.reason = ErrorReason::none;
    if (error.reason == ErrorReason::exhausted) return error;
    if (!failure || tolerance == 0) failure = std::move(error);
  }
  return *failure;
}

}  // namespace overtet
