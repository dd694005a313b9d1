// What a strategy for meshing a surface (strategies.h) is given. Internal to src/pipeline.
#pragma once

#include <optional>
#include <vector>

#include "overtet/report.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/diagnose.h"
#include "src/pipeline/flow_series.h"
#include "src/pipeline/pipeline.h"
#include "src/pipeline/stage_files.h"
#include "src/pipeline/unit_box.h"

namespace overtet {

// More than 12 members: what all stages of one run share.
struct MeshingJob {
  const Surface& surface;  // in the unit box
  const UnitBox& box;
  const Diagnosis& diagnosis;
  const RunContext& context;
  std::vector<StageRecord>& records;  // every stage adds its own
  Preset preset = Preset::standard;
  double patience = 1;                          // with TetGen; src/cdt/tetgen.h
  StageFiles* save = nullptr;                   // where to keep the states
  const StageFiles* resume = nullptr;           // states of an earlier run
  FlowSeries* film = nullptr;                   // where to keep every state of the flows
  std::optional<Error> part_without_mesh = {};  // of a part that has none by itself: why
  PaperRecipe recipe = {};                      // of Preset::paper
  FlowMap flow_map = FlowMap::patch;            // of Preset::flow, and where the flow route comes last
  struct Allowed {
    bool branches = false, flips = false;  // MeshingOptions
  } allowed = {};
};

// Keeps a state where the user asked for that. Errors: io.
template <class Geometry>
Status keep(const MeshingJob& job, const char* name, const Geometry& geometry) {
  return job.save ? job.save->save(name, geometry) : success();
}

// Errors after which no other strategy is tried, whatever it could do.
inline bool ends_run(const Error& e) {
  return e.code == ErrorCode::limit || e.code == ErrorCode::interrupted || e.code == ErrorCode::io;
}

}  // namespace overtet
