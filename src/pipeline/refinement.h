// Meshes where only the one turn around every interior edge, or the way the faces lie, forbids one: of the
// same surface with a few faces subdivided, or of the surface as it is, with branch lines inside.
//
//  1. Wound edges need edges that are covered all along. Where there are none, faces are subdivided along
//     ways that are (src/covering/covered_network.h): first between the hinges that no edges pair; then,
//     where that is not enough, all such ways around what forbids the mesh, in more and more rings.
//  2. The subdivided surface is meshed as ever, hinges, proofs and all.
//  3. Added vertices that no wound edge needs leave the surface again (src/immersion/boundary_recovery.h).
//     What is left is `refine`'s answer.
//  4. For `branch` the others leave it, too. The tets at a wound edge a-m made its angle and 2 pi more; with
//     m inside, they make two turns around it. All tets at m stay positive when it moves by little enough,
//     so this can always be done but for digits.
#pragma once

#include <array>
#include <vector>

#include "overtet/meshing.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/diagnose.h"

namespace overtet {

struct RefinedMesh {
  RefinedSurface shape;                            // of `refine`, where a face is subdivided; else empty
  TetMesh mesh;                                    // in the input's space, improved and checked
  std::vector<std::array<Index, 2>> branch_edges;  // of `branch`, sorted
};

// Whether subdividing faces, or branch lines, may help: nothing is found that forbids these, too.
bool refinable(const Error& why, const Diagnosis& diagnosis);

// diagnosis: of the surface; its graph is completed. why: there is no mesh of the surface as it is.
// Errors: `why` with what was tried, where nothing was found; limit, interrupted.
Result<RefinedMesh> mesh_refined(const Surface& surface, const Diagnosis& diagnosis, const Error& why,
                                 const MeshingOptions& options, const RunContext& context,
                                 std::vector<StageRecord>& records);

}  // namespace overtet
