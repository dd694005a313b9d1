// Points through which several parts of the surface pass, and what the discs there need together.
//
// Let things i = 1, 2, ... pass through a point p: vertices that lie there, edges and faces that have it
// inside. In a mesh of positive tets the tets at thing i meet a tiny sphere around p in a disc without branch
// points (link.h), bounded by the link of the thing: a link polygon, two half great circles, a great circle.
// Let n_i be how often the disc covers the sphere, from place to place. The link alone says how n_i jumps, so
// n_i = w_i + a_i, with w_i known from the link, 0 where it is least, and a_i >= 0 a number. What else of the
// mesh lies over p covers all of the sphere, m >= 0 times. The sum is the winding number W around p:
//
//     sum a_i + m = C,    C = W - sum w_i,
//
// and C is the same all over the sphere. So a_i <= C for each i; at an edge, a_i is the number of turns that
// its tets make more than the surface shows, and bounds it at every point of the edge. If no disc with less
// than l_i layers more than w_i has the link of vertex i as boundary (edges turning no more than that), and
// sum l_i > C, there is no mesh. With one thing only that is the statement of link.h; C < 0 is one, too.
//
// Nothing moves, and nothing is asked of who else is there: copies of a surface in one place, components that
// touch, vertices, edges and faces that meet in any way.
#pragma once

#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/covering/hinges.h"
#include "src/covering/pierced_edge.h"
#include "src/covering/wound_edges.h"
#include "src/mesh/topology.h"

namespace overtet {

// The points among the vertices asked about where the discs need more than there is, by vertex. vertices:
// hinges, and others that lie on other parts of the surface; vertices in the same place are looked at as
// well. Of very many, the last ones are not looked at. Errors: limit or interrupted.
Result<std::vector<SharedPoint>> find_shared(const Surface& surface, const SurfaceTopology& topology,
                                             const TriangleBvh& bvh, const std::vector<Hinge>& hinges,
                                             const std::vector<PiercedEdge>& pierced,
                                             const std::vector<Index>& vertices, const RunContext& context);

}  // namespace overtet
