#include "overtet/repair.h"

#include "src/pipeline/pipeline.h"

namespace overtet {

Result<SurfaceRepair> repair_surface(const Surface& surface, const SurfaceRepairOptions& options,
                                     const RunContext& context, Report* report) {
  MeshingOptions meshing;
  meshing.on_infeasible = OnInfeasible::repair;
  meshing.max_repair_move = options.max_relative_move;
  meshing.improve_degrees = 0;  // the mesh only shows that there is one
  PipelineResult run = run_pipeline(surface, meshing, context);
  if (report) *report = run.report;
  if (!run.ok()) return std::move(run.error);
  SurfaceRepair repaired;
  repaired.surface = {run.mesh.V.topRows(surface.V.rows()), surface.F};
  repaired.moved.assign(run.report.moved_ids.begin(), run.report.moved_ids.end());
  repaired.max_relative_move = run.report.max_relative_move;
  repaired.mean_relative_move = run.report.mean_relative_move;
  return repaired;
}

}  // namespace overtet
