// The stages of the flow route, each with its record in the report. Internal to src/pipeline.
#pragma once

#include <optional>

#include "overtet/result.h"
#include "overtet/types.h"
#include "src/forward_flow/forward_flow.h"
#include "src/pipeline/meshing_job.h"
#include "src/reverse_flow/reverse_flow.h"
#include "src/tet_mesh/tet_mesh.h"
#include "src/volume_map/volume_map.h"

namespace overtet {

Result<ForwardFlowResult> flow_forward(const MeshingJob& job, const ForwardFlowOptions& options);

// Work and time are limited as the options say, and so that something is left for the volume map.
Result<ReverseFlowResult> flow_back(const MeshingJob& job, const ForwardFlowResult& forward,
                                    ReverseFlowOptions options);

Result<TetMesh> fill(const MeshingJob& job, const VertexMatrix& U0, const TetMeshOptions& options = {});

// The same from a saved state, the latest one there is; none when there is none. Errors: bad_input (damaged),
// too.
std::optional<Result<TetMesh>> saved_fill(const MeshingJob& job, const TetMeshOptions& options = {});

enum class MapCare {
  usual,
  careful  // more around what is away that may move, a force that grows slowly, and more vertices added
};

// What locks is kept as a problem of its own.
Result<TetMesh> map(const MeshingJob& job, const TetMesh& mesh, MapCare care);

}  // namespace overtet
