// From a surface to a checked tet mesh: the only room that knows the order of the stages.
//
//   diagnose -> (clean)     tet_mesh ------------------------------------------------> improve -> verify
//            -> (immersion) immersion (arrangement, tet mesh, sheets) ---------------> improve -> verify
//            -> (flow)      forward_flow -> reverse_flow -> tet_mesh -> volume_map --> improve -> verify
//
// Where there is no mesh and repairing is asked for, the same with a repaired surface in the input's place.
//
// The immersion route needs no flow and is tried first; the flow route is the paper's (Sacht et al. 2013) and
// is taken when the first one finds nothing (unless it has tried everything there is), or alone when asked
// for. Whatever made the mesh, it is checked exactly against the surface as it was read before it is handed
// out.
//
// Same surface, same options: same mesh, on any number of threads.
#pragma once

#include <string>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/pipeline/result_hash.h"
#include "src/report/report.h"

namespace overtet {

enum class Preset { standard, flow };
enum class OnInfeasible { reject, repair };

struct PipelineOptions {
  Preset preset = Preset::standard;
  OnInfeasible on_infeasible = OnInfeasible::reject;
  double max_repair_move = 0.06;  // of a vertex, relative to the diagonal of the bounding box
  double improve_degrees = 17;    // smallest dihedral angle that the quality pass aims at; 0: no pass
  std::string save_stages;        // folder for the intermediate states; empty: none
  std::string resume;             // folder to take them from; empty: none

  Status validate() const;
};

struct PipelineResult {
  TetMesh mesh;  // only when error.code is none: ok()
  Report report;
  Error error;  // why there is no mesh
  bool ok() const { return report.status == RunStatus::exact || report.status == RunStatus::repaired; }
  int exit_code() const { return ok() ? 0 : static_cast<int>(error.code); }
};

// Never throws: what is thrown below (no memory left, a bug) comes back as an error.
PipelineResult run_pipeline(const Surface& surface, const PipelineOptions& options,
                            const RunContext& context);

// The report's status for an error.
RunStatus status_of(ErrorCode code);

}  // namespace overtet
