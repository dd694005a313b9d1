// Edges of a surface that other faces pierce: by which faces, where, and what lies between the places.
//
// The outer side of an edge has a winding number m_e, its level, which changes where a face pierces the edge.
// A positive tet mesh can turn around the edge m_e times more than the surface shows, at most (hinges.h).
#pragma once

#include <optional>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/types.h"
#include "src/mesh/topology.h"

namespace overtet {

// Faces that contain a point of the inside of an edge and do not belong to it.
struct PiercedEdge {
  Index half_edge = -1;      // the smaller one of the two
  std::vector<Index> faces;  // sorted
};

// Sorted by half-edge. pairs: all intersecting pairs of the surface.
std::vector<PiercedEdge> find_pierced_edges(const Surface& surface, const SurfaceTopology& topology,
                                            const std::vector<FacePair>& pairs);

// The faces that pierce an edge, given by either half-edge; none where nothing does. pierced: of
// find_pierced_edges, and must outlive the answer.
const std::vector<Index>& piercing_faces(const std::vector<PiercedEdge>& pierced,
                                         const SurfaceTopology& topology, Index half_edge);

// The level of each part into which `piercing` cuts the edge, from the source of `half_edge` to its target.
// Exact. None where the edge runs inside another face.
std::optional<std::vector<int>> edge_levels(const Surface& surface, const SurfaceTopology& topology,
                                            const TriangleBvh& bvh, Index half_edge,
                                            const std::vector<Index>& piercing);

}  // namespace overtet
