// From a surface to a checked tet mesh: the only room that knows the order of the stages.
//
//   diagnose -> (clean)     tet_mesh ------------------------------------------------> improve -> verify
//            -> (immersion) immersion (arrangement, tet mesh, sheets) ---------------> improve -> verify
//            -> (flow)      forward_flow -> tet_mesh -> patch -----------------------> improve -> verify
//                           or, where that fails, -> reverse_flow -> tet_mesh -> patch | volume_map ->
//            -> (paper)     forward_flow -> reverse_flow -> tet_mesh -> lim | volume_arap | volume_map ->
//            verify
//
// Where there is no mesh and that is asked for, the same with a repaired or a refined surface in the input's
// place.
//
// The immersion route needs no flow and is tried first; the flow route is the paper's (Sacht et al. 2013) and
// is taken when the first one finds nothing (unless it has tried everything there is), or alone when asked
// for; the paper's recipe to the letter is for those who ask for it by name. Whatever made the mesh, it is
// checked exactly against the surface as it was read before it is handed out.
//
// Same surface, same options: same mesh, on any number of threads.
#pragma once

#include <string>

#include "overtet/meshing.h"
#include "overtet/report.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/pipeline/result_hash.h"

namespace overtet {

struct PipelineResult {
  TetMesh mesh;  // only when ok()
  Report report;
  Error error;             // why there is no mesh
  RefinedSurface refined;  // of status `refined`
  bool ok() const {
    return report.status == RunStatus::exact || report.status == RunStatus::repaired ||
           report.status == RunStatus::refined || report.status == RunStatus::branched ||
           report.status == RunStatus::flipped;
  }
  int exit_code() const { return ok() ? 0 : static_cast<int>(error.code); }
};

// Never throws: what is thrown below (no memory left, a bug) comes back as an error.
PipelineResult run_pipeline(const Surface& surface, const MeshingOptions& options, const RunContext& context);

}  // namespace overtet
