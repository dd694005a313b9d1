// Which boundary edges a positive tet mesh winds around once more than the surface shows.
//
// At every vertex p a positive mesh has B0(p) = 2 c_p + sum of k_e (hinges.h), with 0 <= c_p <= the
// smallest winding number around p and 0 <= k_e <= the outer winding number all along e. At an ordinary
// vertex B0 = 2 w with w the number of layers over it, so the wound edges form chains that end at hinges
// only. The assignment pairs the hinges' odd ends by chains of edges that are legal everywhere, at minimum
// total cost: edges that no other face pierces are preferred by far (what winds around them then stays in
// one layer of the other parts), then few edges, then short ones.
//
// Exact: capacities come from exact rays between the exact crossings of an edge with the surface. The
// pairing is optimal up to kExactEnds ends in one region (dynamic programming over subsets), beyond that
// improved by exchanges until none helps; chains are then routed one after another within what the earlier
// ones left, so that every result given as complete satisfies all equations (they are checked at the end).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/covering/hinges.h"
#include "src/covering/pierced_edge.h"
#include "src/mesh/topology.h"

namespace overtet {

struct WoundEdge {
  Index a = -1, b = -1;  // a < b
  int k = 1;             // the interior dihedral in the mesh is theta_e + 2 pi k
  bool pierced = false;  // another face crosses the inside of the edge
};

// A point where several parts of the surface meet, and these vertices' discs need more layers, in all, than
// there is room for (shared_points.h). As a rule they do; room < 0 forbids a mesh whatever they need.
struct SharedPoint {
  std::vector<Index> vertices;
  std::vector<int> layers;  // that each needs at least, above the least that its link shows
  int room = 0;
};

struct WoundEdges {
  std::vector<WoundEdge> edges;  // sorted
  std::vector<Index> unmet;      // hinges whose equation does not hold with these edges, sorted
  // Groups of hinges with odd B0 that legal edges (outer side covered all along) join to each other and
  // to no others, an odd number in each. That is a proof that no positive mesh with one turn around every
  // interior edge exists: over such a group the sum of B0 would have to be even. A single vertex whose
  // edges are all uncovered somewhere is the usual case.
  std::vector<std::vector<Index>> odd_groups;
  // Hinges whose edges cannot take the turns that B0 asks for: for every c from 0 to the smallest level next
  // to the hinge, the edges have room for less than B0 - 2 c turns, an edge for its smallest level all along,
  // and for c less than its level next to the hinge. As much of a proof. Sorted.
  std::vector<Index> crowded;
  // Hinges, not crowded, whose surroundings positive tets cannot fill: no disc on the sphere has their link
  // polygon as boundary, with the layers that the winding numbers give, turning at every edge as often as the
  // edge has room for all along. As much of a proof. Sorted.
  std::vector<Index> unfillable;
  // What is wrong at a point shared by the vertices in `unfillable`, as much of a proof.
  std::optional<SharedPoint> shared;
  std::string explanation;  // one sentence where there are some unmet, though nothing here forbids a mesh
  bool complete() const { return unmet.empty(); }
  bool forbidden() const { return !odd_groups.empty() || !crowded.empty() || !unfillable.empty(); }
};

// pairs: all intersecting pairs; hinges and pierced: of find_hinges and find_pierced_edges.
// Errors: limit or interrupted only; what cannot be met is in `unmet`. Where a hinge is unmet because no
// legal edge leaves it, or because an odd number of ends can reach each other, `odd_groups` proves that no
// mesh exists; other unmet hinges only say that none was found.
Result<WoundEdges> assign_wound_edges(const Surface& surface, const SurfaceTopology& topology,
                                      const TriangleBvh& bvh, const std::vector<Hinge>& hinges,
                                      const std::vector<PiercedEdge>& pierced, const RunContext& context);

}  // namespace overtet
