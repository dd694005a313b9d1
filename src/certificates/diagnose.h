// Everything that can be known about a surface before anything is moved: what `overtet inspect` prints,
// what the pipeline's first stage decides on, and what the report's "input" and "witness" hold.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/stacks.h"
#include "src/certificates/winding_range.h"
#include "src/covering/hinges.h"
#include "src/covering/pierced_edge.h"
#include "src/covering/wound_edges.h"
#include "src/mesh/topology.h"

namespace overtet {

class IntersectionGraph;

struct DiagnoseOptions {
  // The whole winding range even when a witness has been found early. `inspect` wants it, `mesh` need not.
  bool full_winding_range = true;
  // The wound edges are looked for only where nothing else forbids a mesh.
  bool wound_edges = true;
  Status validate() const { return success(); }
};

enum class Verdict {
  bad_input,   // not a closed, oriented, manifold surface of faces with area
  embedded,    // no two faces intersect and the winding is right: a plain tet mesh will do
  feasible,    // passes through itself; nothing that forbids a mesh was found
  infeasible,  // no mesh exists: a point of negative winding, or a vertex with B0 < 0
  obstructed   // no mesh exists: hinges that cannot be paired (wound.odd_groups), whose edges cannot take the
               // turns (wound.crowded) or that no tets can fill (wound.unfillable), B0 < 0 at a fold, or
               // coplanar faces that lie on each other as they must not (stack)
};
const char* verdict_name(Verdict verdict);

// A vertex whose integer forbids a mesh.
struct VertexWitness {
  Index vertex = -1;
  int B0 = 0;
};

struct DiagnosisTimes {  // seconds of wall time
  double topology = 0, pairs = 0, hinges = 0, winding = 0, wound_edges = 0;
};

// What is wrong with the topology, or with a face, ends the diagnosis: the verdict is bad_input then, and
// what follows `degenerate_faces` is empty, like component_volume.
struct Diagnosis {
  Verdict verdict = Verdict::bad_input;
  std::string message;  // one sentence: why the verdict
  Index vertices = 0, faces = 0;
  TopologyCheck topology;                // flags, problems; with the adjacency when they are fine
  std::vector<double> component_volume;  // signed, as the faces turn; negative: the component faces inwards
  std::vector<Index> degenerate_faces;
  std::vector<FacePair> pairs;  // sorted
  Index pairs_sharing_vertex = 0, pairs_sharing_edge = 0;
  std::vector<Hinge> hinges;
  std::vector<PiercedEdge> pierced_edges;
  WindingRange winding;  // with the point of negative winding
  std::optional<VertexWitness> vertex_witness;
  // A vertex with B0 < 0 where doubles cannot tell a dihedral of 0 from 2 pi. As much of a proof, but only
  // for who computes exactly.
  std::optional<VertexWitness> fold_witness;
  std::optional<StackWitness> stack;  // looked for where nothing above forbids a mesh
  WoundEdges wound;
  std::vector<std::string> advice;  // sentences for a person
  DiagnosisTimes times;
  // Of the surface as it is; null when the diagnosis ended early. The graph of its pairs is handed on to all
  // that goes on with them (intersection_graph.h), and grows there.
  std::shared_ptr<const TriangleBvh> bvh;
  std::shared_ptr<IntersectionGraph> graph;

  bool complete() const { return bvh != nullptr; }
  int genus() const {
    int sum = 0;
    for (const SurfaceComponent& c : topology.topology.components) sum += c.genus;
    return sum;
  }
};

// Errors: limit or interrupted only. What is wrong with the surface is in the diagnosis.
Result<Diagnosis> diagnose(const Surface& surface, const DiagnoseOptions& options, const RunContext& context);

// Diagnosis::component_volume. pre: the topology is fine.
std::vector<double> component_volumes(const Surface& surface, const SurfaceTopology& topology);

// What `overtet mesh` must answer at once, if anything: bad_input (3) or infeasible (5) with the message.
std::optional<Error> refuse(const Diagnosis& diagnosis);

}  // namespace overtet
