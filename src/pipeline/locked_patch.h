// The part of a surface around the place where a stage found no way on, to look at and to try alone.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/types.h"
#include "src/mesh/submesh.h"

namespace overtet {

// The faces at a place, some rings around them, the faces that those intersect (pairs: all intersecting pairs
// of the surface), and a ring around these. Vertices and faces keep their order, coordinates their bits; the
// patch is open.
SubSurface patch_around(const Surface& surface, const std::vector<FacePair>& pairs,
                        const Eigen::Vector3d& place);

// The part of a volume map around boundary vertices that did not reach their places, as a problem of its own:
// a closed surface, and a positive tet mesh with the same faces whose vertices are where they got to. Where
// the patch was cut out of the mesh both are in the same place.
struct LockedSolid {
  Surface target;
  TetMesh start;                // its boundary vertices first, in the order of `target`
  std::vector<Index> vertices;  // of the mesh: the number of each of start's
};
// The tets within some rings of `away` (more where the patch would be pinched); the whole mesh if need be.
// pre: mesh is a solid whose first surface_vertices (rows of target) are its boundary's.
LockedSolid solid_around(const TetMesh& mesh, const VertexMatrix& target, const std::vector<Index>& away);

}  // namespace overtet
