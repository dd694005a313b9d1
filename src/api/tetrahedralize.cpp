#include "overtet/meshing.h"
#include "src/pipeline/pipeline.h"

namespace overtet {

Result<Meshing> tetrahedralize(const Surface& surface, const MeshingOptions& options,
                               const RunContext& context, Report* report) {
  PipelineResult run = run_pipeline(surface, options, context);
  Report& told = run.report;
  if (report) *report = told;
  if (!run.ok()) return std::move(run.error);
  Meshing made;
  made.mesh = std::move(run.mesh);
  made.quality = told.quality.value_or(TetQuality{});
  made.moved.assign(told.moved_ids.begin(), told.moved_ids.end());
  made.max_relative_move = told.max_relative_move;
  made.refined = std::move(run.refined);
  made.branch_edges = std::move(told.branch_edges);
  made.flipped_tets = std::move(told.flipped_tets);
  made.hash = std::move(told.result_hash);
  return made;
}

}  // namespace overtet
