#include "src/immersion/cell_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <optional>

#include "kernels/bvh/self_intersections.h"
#include "kernels/parallel/parallel.h"
#include "src/immersion/tuning.h"
#include "src/run/stopwatch.h"

namespace overtet {

namespace {

// Faces that intersect and nearly lie in one plane: where exact cuts depend on the last bits.
bool nearly_coincides(const Surface& surface, const std::vector<FacePair>& pairs) {
  const auto normal = [&](Index f) {
    const Eigen::Vector3d a = surface.V.row(surface.F(f, 0)), b = surface.V.row(surface.F(f, 1)),
                          c = surface.V.row(surface.F(f, 2));
    return Eigen::Vector3d((b - a).cross(c - a).normalized());
  };
  return std::any_of(pairs.begin(), pairs.end(), [&](const FacePair& p) {
    return normal(p.first).cross(normal(p.second)).norm() < kFlat;
  });
}

}  // namespace

Result<CellMesh> mesh_cells(const Surface& surface, const std::vector<FacePair>& pairs,
                            const CellMeshOptions& options, const RunContext& context) {
  context.report("immersion", 0, "arrangement");
  CellMesh out;
  // The Delaunay tets of the surface's own vertices are serial work and need no arrangement.
  std::optional<Result<Arrangement>> arranged;
  DelaunayStart delaunay;
  {
    const Stopwatch watch(out.arrangement_seconds);
    parallel_invoke([&] { arranged = arrange(surface, pairs, {options.tolerance}, context); },
                    [&] {
                      if (options.tolerance == 0) delaunay = begin_delaunay(surface.V, surface.F, context);
                    });
  }
  if (!*arranged) return arranged->error();
  out.arrangement = std::move(*arranged).value();

  context.report("immersion", 0.2, "tet mesh");
  Plc plc;
  plc.V = out.arrangement.V;
  plc.F = out.arrangement.F;
  plc.markers.resize(plc.F.rows());
  for (std::size_t g = 0; g < plc.markers.size(); ++g) plc.markers[g] = static_cast<Index>(g) + 1;
  TetgenOptions tetgen;
  tetgen.quality = options.radius_edge > 0 && worth_refining(plc.V, plc.F);
  if (tetgen.quality) tetgen.radius_edge = options.radius_edge;
  tetgen.patience = options.patience;
  tetgen.free_points = true;
  tetgen.accept_split = true;  // added points leave the boundary like those of the arrangement
  if (delaunay.builder.points() - delaunay.free_points.rows() != out.arrangement.input_positions)
    delaunay = {};  // vertices in one place
  std::optional<Result<TetgenResult>> tets;
  {
    const Stopwatch watch(out.tet_mesh_seconds);
    tets = tetrahedralize_stubbornly(plc, tetgen, context, std::move(delaunay));
  }
  if (!*tets) return tets->error();
  out.tets = std::move(*tets).value();
  return out;
}

std::vector<double> arrangement_tolerances(const Surface& surface, const std::vector<FacePair>& pairs) {
  std::vector<double> order(std::begin(kTolerances), std::end(kTolerances));
  order.insert(order.begin() + (nearly_coincides(surface, pairs) ? kCoincidentFirst : 0), 0.0);
  return order;
}

}  // namespace overtet
