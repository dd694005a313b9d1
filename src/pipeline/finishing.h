// The end of every run: the quality pass, and the exact check against the surface as it was read.
#pragma once

#include <vector>

#include "overtet/meshing.h"
#include "overtet/report.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/pipeline/unit_box.h"

namespace overtet {

struct FinishingJob {
  const Surface& input;    // as it was read
  double improve_degrees;  // MeshingOptions
  const RunContext& context;
  std::vector<StageRecord>& records;
  TetSizes sizes = {};          // MeshingOptions
  bool allow_branches = false;  // VerifyOptions
  Index placed = 0;             // Draft
  // MeshingOptions: a mesh with tets that are not positive is left as it was made; all that needs no positive
  // tets is checked.
  bool allow_flips = false;
};

// The mesh improved, in the input's space and checked: every face of the input is a boundary face, every
// vertex where it was to the last bit. As it was made where the quality pass made it wrong.
// mesh: in the unit box. Errors: unsolved (the mesh is wrong), limit, interrupted.
Result<TetMesh> finish(const FinishingJob& job, const UnitBox& box, TetMesh mesh);

// The same for a mesh in the input's space. Errors: bad_input, too (no unit box for the input).
Result<TetMesh> finish_given(const FinishingJob& job, TetMesh mesh);

}  // namespace overtet
