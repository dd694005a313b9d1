// A surface's mesh, or, where there is none and that is asked for, that of a repaired or a refined surface,
// or one with branch lines: as one, or where it has parts that these can tell apart, part by part first.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/pipeline/pipeline.h"
#include "src/pipeline/repair_job.h"

namespace overtet {

struct MeshedSurface {
  TetMesh mesh;                                    // in the input's space, improved and checked
  std::optional<Moves> moves;                      // of a repaired surface
  std::optional<RefinedSurface> refined;           // what it is a mesh of, where faces were subdivided
  std::vector<std::array<Index, 2>> branch_edges;  // sorted
  std::vector<Index> flipped_tets;                 // sorted; of allow_flips
};

// Into the report goes what is found of the surface as it was read, and the stages' records as they come;
// nothing of what was tried in vain. What the mesh is like is not.
// Errors: why there is no mesh.
Result<MeshedSurface> mesh_or_repair(const Surface& surface, const MeshingOptions& options,
                                     const RunContext& context, Report& report);

}  // namespace overtet
