// One surface, as it is, from the diagnosis to a checked mesh: no repairs.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "overtet/report.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/pipeline/component_meshing.h"
#include "src/pipeline/inspection.h"
#include "src/pipeline/meshing_job.h"
#include "src/pipeline/pipeline.h"
#include "src/pipeline/stage_files.h"

namespace overtet {

struct SurfaceRunSetup {
  enum class Origin {
    read,      // by the user
    repaired,  // and repaired again where no mesh is found: no search for a proof, and no flows after a
               // failure
    refined    // and refined further where no mesh is found: a search for a proof, which says where, but no
               // flows after a failure
  };
  Origin origin = Origin::read;
  double patience = 1;  // with TetGen; src/cdt/tetgen.h
  InspectionDepth depth = InspectionDepth::verdict;
};

// Nothing is written anywhere but the stages' records: what was found is asked for.
// More than 12 members: what is known of the surface by now, and where it is kept.
class SurfaceRun {
 public:
  // The arguments must live as long as the run.
  SurfaceRun(const Surface& input, const SurfaceRunSetup& setup, const MeshingOptions& options,
             const RunContext& context, std::vector<StageRecord>& records);

  // Errors: what forbids a mesh (bad_input, infeasible), limit, interrupted.
  Status diagnose();
  // In the input's space, improved and checked. pre: diagnose() succeeded.
  Result<TetMesh> mesh();
  // Both, one after the other.
  Result<TetMesh> go();

  // What is known of the surface so far, also after a failure.
  const InputRecord& input_record() const { return record_; }
  const std::optional<Certificate>& certificate() const { return found_.diagnosis.certificate; }
  const Diagnosis& diagnosis() const { return found_.diagnosis; }
  // Where the sheets could not be glued, in the input's space.
  const std::optional<Eigen::Vector3d>& unglued() const { return unglued_; }
  std::vector<SubSurface> parts() const { return parts_of(input_, found_.diagnosis); }

 private:
  Status open_files();
  Result<TetMesh> finish_saved();
  Result<TetMesh> finish(Draft draft);
  Result<TetMesh> try_strategies();
  std::optional<Error> final_reason(const Error& failure);
  Status look_closer();
  bool may_try_all_the_same() const;

  const Surface& input_;
  const SurfaceRunSetup setup_;
  const MeshingOptions& options_;
  const RunContext& context_;
  std::vector<StageRecord>& records_;

  InputRecord record_;
  Inspection found_;
  Surface surface_;  // in the unit box
  std::optional<StageFiles> save_, resume_;
  std::optional<FlowSeries> film_;
  std::optional<Eigen::Vector3d> unglued_;
  bool looked_closer_ = false;
};

}  // namespace overtet
