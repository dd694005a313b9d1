// What is gathered about a surface before anyone decides whether it has a mesh.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/winding_range.h"
#include "src/covering/hinges.h"
#include "src/covering/pierced_edge.h"
#include "src/covering/wound_edges.h"
#include "src/mesh/topology.h"

namespace overtet {

class IntersectionGraph;

struct GatheringTimes {  // seconds of wall time
  double topology = 0, pairs = 0, hinges = 0, winding = 0;
  double wound_edges = 0;  // with the rules
};

// More than 12 members: every room tells what it found of one surface, and others read it by itself.
struct Facts {
  Index vertices = 0, faces = 0;
  TopologyCheck topology;                // flags, problems; with the adjacency when they are fine
  std::vector<double> component_volume;  // signed, as the faces turn; negative: the component faces inwards
  std::vector<Index> degenerate_faces;
  std::vector<FacePair> pairs;  // sorted
  Index pairs_sharing_vertex = 0, pairs_sharing_edge = 0;
  std::vector<Hinge> hinges;
  std::vector<PiercedEdge> pierced_edges;
  WindingRange winding;
  WoundEdges wound;  // looked for by the first rule that needs them
  bool wound_is_known = false;
  // Of the surface as it is; null when the diagnosis ended early. The graph of its pairs is handed on to all
  // that goes on with them (intersection_graph.h), and grows there.
  std::shared_ptr<const TriangleBvh> bvh;
  std::shared_ptr<IntersectionGraph> graph;
  GatheringTimes times;

  // Whether there is more than topology and degenerate faces to look for.
  bool well_formed() const { return topology.ok() && degenerate_faces.empty(); }
  bool complete() const { return bvh != nullptr; }  // the rest has been looked for
  int genus() const {
    int sum = 0;
    for (const SurfaceComponent& c : topology.topology.components) sum += c.genus;
    return sum;
  }
};

// Topology and degenerate faces.
Facts check_shape(const Surface& surface);

// The rest, without the wound edges. full_winding_range: also after a point of negative winding number has
// been found. pre: facts.well_formed(). Errors: limit or interrupted.
Status gather_facts(const Surface& surface, bool full_winding_range, const RunContext& context, Facts& facts);

// Facts::component_volume. pre: the topology is fine.
std::vector<double> component_volumes(const Surface& surface, const SurfaceTopology& topology);

// Whether who computes a hinge's integer from rounded angles gets it right.
bool is_checkable(const Hinge& hinge);

// The one with B0 < 0 whose integer is easiest to check; null where there is none.
const Hinge* clearest_negative(const std::vector<Hinge>& hinges);

// The integer of a hinge; 0 where it is not defined or the vertex is none. hinges: by vertex.
int b0_of(const std::vector<Hinge>& hinges, Index vertex);

std::array<double, 3> position_of(const Surface& surface, Index vertex);
std::vector<std::array<double, 3>> positions_of(const Surface& surface, const std::vector<Index>& vertices);

}  // namespace overtet
