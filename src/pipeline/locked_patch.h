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

}  // namespace overtet
