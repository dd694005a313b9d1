// Some of a surface's faces as a surface of their own.
#pragma once

#include <vector>

#include "overtet/types.h"
#include "src/mesh/topology.h"

namespace overtet {

// Vertices and faces keep their order, coordinates their bits.
struct SubSurface {
  Surface surface;
  std::vector<Index> vertices, faces;  // the whole surface's number of each of its own
};

// The faces, ascending, and the vertices that they have. O(#V + #F).
SubSurface sub_surface(const Surface& whole, std::vector<Index> faces);

// All faces of the components for which `wanted` is set.
SubSurface sub_surface(const Surface& whole, const SurfaceTopology& topology,
                       const std::vector<char>& wanted);

}  // namespace overtet
