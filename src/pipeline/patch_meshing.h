// The tet mesh of the embedding U0 brought home to V0 by making anew what must move: the tets around the
// boundary vertices whose places in U0 and V0 differ are taken out, the closed surface around them, with its
// boundary vertices at home and the others where they are, is meshed as any surface is (by the immersion, if
// it crosses itself), and the tets that were left are glued on again.
//
// Why: what keeps the volume map (src/volume_map) from coming home is seldom how far vertices have to go, but
// the way there. No way is needed here, and nothing is moved. Measured: .3 to 1.7 s where the pull takes 9 to
// 338, also on all models where it locks (docs/paper.md).
//
// What it needs of U0: that it is V0 nearly everywhere (src/forward_flow, regional).
#pragma once

#include "overtet/result.h"
#include "overtet/types.h"
#include "src/pipeline/draft.h"
#include "src/pipeline/meshing_job.h"

namespace overtet {

// Exact: checked against the surface. A patch that has no mesh, or has one that makes an edge of the cut turn
// twice, is made a ring wider, kRings times at most.
// embedded: of stage tet_mesh, boundary U0.
// Errors: unsolved (also where the patch would be all of the mesh), limit, interrupted.
Result<Draft> mesh_by_patch(const MeshingJob& job, const TetMesh& embedded);

}  // namespace overtet
