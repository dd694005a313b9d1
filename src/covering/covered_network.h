// Where edges could be wound if the faces of a surface were subdivided: a network of paths over the covered
// parts of the surface, those with a positive winding number on their outer side.
//
// The wound edges of a mesh (wound_edges.h) run along edges that are covered all along. Where a covered strip
// between two curves is narrower than the faces, no edge runs in it, and hinges at its ends cannot be joined;
// with edges across the faces they can. B0 is 2 w at a point of a face, so a chain of wound edges may pass.
//
// The network: each part of a cut face (between the curves, exactly: face_cuts.h) is cut into triangles.
// Links lead from the middle of one to the next, to corners that are vertices, and to the middles of the
// pieces of the surface's edges. Places are rounded to the grid of src/mesh/subdivision.h; who subdivides the
// surface diagnoses it anew.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "kernels/bvh/bvh.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/mesh/subdivision.h"
#include "src/mesh/topology.h"

namespace overtet {

class IntersectionGraph;

struct CoveredNetwork {
  struct Link {
    Index a, b;       // nodes
    Index face = -1;  // that it runs in, or -1: along an edge of the surface
    double length = 0;
  };
  std::vector<FacePoint> points;  // the nodes after the surface's vertices
  std::vector<Link> links;
  // Pieces of curves, by face, that no link may cross: one side is not covered. Barycentric coordinates.
  struct Barrier {
    Index face;
    std::array<std::array<double, 3>, 2> ends;
  };
  std::vector<Barrier> barriers;  // by face
  std::string problem;            // why there is no network: the surface is not in general position

  // Whether a straight line between two nodes of a face stays where it is covered.
  bool sees(const Surface& surface, const SurfaceTopology& topology, Index face, Index a, Index b) const;
};

// graph: of all intersecting pairs. Errors: limit or interrupted.
Result<CoveredNetwork> find_covered_network(const Surface& surface, const SurfaceTopology& topology,
                                            const TriangleBvh& bvh, IntersectionGraph& graph,
                                            const RunContext& context);

// Links that lead from each of the groups of vertices that covered edges join, and that has an odd number of
// `odd` ones, to another one, so that none is left; few faces, and short. Those in faces only. Empty where
// the network does not join them.
std::vector<CoveredNetwork::Link> links_between(const Surface& surface, const CoveredNetwork& network,
                                                const std::vector<Index>& odd);

// The same links without nodes inside faces that lead straight on: with the two links at them made one, where
// that stays covered.
std::vector<CoveredNetwork::Link> pulled_tight(const Surface& surface, const SurfaceTopology& topology,
                                               const CoveredNetwork& network,
                                               const std::vector<CoveredNetwork::Link>& links);

// The same links without chains that end where they begin, and with one of those that have both ends in
// common, that of the fewest links.
std::vector<CoveredNetwork::Link> without_loops(const Surface& surface,
                                                const std::vector<CoveredNetwork::Link>& links);

// What makes links edges of a surface: points, edges, and the node that each point is.
struct Additions {
  std::vector<FacePoint> points;
  std::vector<FaceEdge> edges;
  std::vector<Index> nodes;
};
Additions additions(const Surface& surface, const CoveredNetwork& network,
                    const std::vector<CoveredNetwork::Link>& links);

}  // namespace overtet
