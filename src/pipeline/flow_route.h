// The paper's route (Sacht et al. 2013): flow the surface until it no longer passes through itself, flow it
// back to its shape without letting it touch itself, fill that with tets, map them to the input.
//
// The flows are tried along their ladder of settings until one result is not locked (a part that stays
// collapsed); the best result goes on. The map is the patch (patch_meshing.h), which needs no good embedding:
// it is tried of what the forward flow ends with, and mostly no surface is flowed back. Where it fails, or is
// not wanted, the pull follows (src/volume_map). When the map fails, the ladder's next rung is tried; when
// none is better, the pull is tried in another way. What locks is saved as a problem of its own (`locked/`),
// small and to be resumed by itself.
#pragma once

#include "overtet/result.h"
#include "src/pipeline/draft.h"
#include "src/pipeline/meshing_job.h"

namespace overtet {

// A positive tet mesh of the surface, not yet checked.
Result<Draft> mesh_by_flow(const MeshingJob& job);

}  // namespace overtet
