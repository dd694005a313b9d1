// A mesh of a surface that has none: of the same surface with a few vertices moved a little.
//
//  1. Away from what forbids a mesh: src/repair moves vertices until nothing objects: gently, and where that
//     does not do as far as it takes. The result is meshed, and repaired further where the sheets could not
//     be glued. If the way back from there is blocked: from other such surfaces, one no vertex of which was
//     moved further than is allowed, one that was moved far and less far after that, one that the forward
//     flow has freed of all crossings (src/forward_flow; it has a mesh unless it faces inwards).
//  2. Back: the boundary of that mesh is pulled to the input again, every tet positive all the way
//     (src/volume_map). Most vertices come home. What is locked ends as near to its place as it gets, and
//     where that is too far, its neighbours give way.
//  3. Less, in rounds, where vertices are further away than allowed: among other tets (the mesh improved, or
//     the surface meshed anew) what was locked is free again, and is pulled once more; the farthest come
//     nearer at the cost of others. Then straight back, vertex by vertex, as far as the diagnosis does not
//     object (moving_less.h). What is within the limit gets room after that (src/opening).
//
// The second step finds what no smoothing can: how parts that are inside out fold up best. Where it does not
// make things better, the first step's result stands; likewise with the third. Work is counted, not timed.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "overtet/result.h"
#include "src/pipeline/repair_job.h"

namespace overtet {

// first: why there is no mesh of the surface as it is; unglued: where its sheets could not be glued, if that
// is known. Errors: `first`, where no repair was found, with what would do if larger moves were allowed;
// limit, interrupted.
Result<RepairedMesh> mesh_repaired(const RepairJob& job, const Error& first,
                                   std::optional<Eigen::Vector3d> unglued);

}  // namespace overtet
