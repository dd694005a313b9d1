// For .cpp files only (exact numbers): where faces pierce an edge, in rational numbers. See pierced_edge.h.
#pragma once

#include <optional>
#include <vector>

#include "overtet/types.h"
#include "src/exact/rays.h"
#include "src/mesh/topology.h"

namespace overtet {

// A place on an edge, from 0 at its source to 1 at its target, where one face pierces it.
struct EdgeCut {
  exact::Rational at;
  int change = 0;  // of the winding number next to the edge, from the source on
};

// Where the planes of `piercing` cut the edge from a to a + e, strictly between its ends, in order. Faces in
// whose plane the edge runs are added to in_plane instead.
std::vector<EdgeCut> edge_cuts(const exact::Rays& rays, const exact::Vec& a, const exact::Vec& e,
                               const std::vector<Index>& piercing, std::vector<Index>& in_plane);

// A part of an edge between two neighbouring cuts.
struct EdgePart {
  exact::Rational from, to;  // 0 at the edge's source, 1 at its target
  int level = 0;             // the winding number on the edge's outer side
};

// All parts, from the source of `half_edge` to its target. None where the edge runs inside another face, or
// no ray could be counted.
std::optional<std::vector<EdgePart>> edge_parts(const exact::Rays& rays, const SurfaceTopology& topology,
                                                Index half_edge, const std::vector<Index>& piercing);

}  // namespace overtet
