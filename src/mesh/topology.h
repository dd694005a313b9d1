// What a surface must be before anything else looks at it: every index valid, every coordinate finite,
// every edge shared by exactly two faces that run along it in opposite directions, the faces around every
// vertex one closed fan. Found errors name the element, so that a user can look at it.
//
// Half-edges: half-edge h = 3 f + k of face f runs from F(f, k) to F(f, (k + 1) % 3). There are no other
// arrays to keep in step.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {

inline Index next_half_edge(Index h) { return h % 3 == 2 ? h - 2 : h + 1; }
inline Index previous_half_edge(Index h) { return h % 3 == 0 ? h + 2 : h - 1; }
inline Index half_edge_face(Index h) { return h / 3; }
inline Index half_edge_source(const TriangleMatrix& F, Index h) { return F(h / 3, h % 3); }
inline Index half_edge_target(const TriangleMatrix& F, Index h) { return F(h / 3, (h + 1) % 3); }
inline Index half_edge_opposite(const TriangleMatrix& F, Index h) { return F(h / 3, (h + 2) % 3); }

struct SurfaceComponent {
  Index faces = 0;
  Index vertices = 0;
  Index first_face = 0;
  Index genus = 0;
};

// Adjacency of a closed, oriented, manifold surface.
struct SurfaceTopology {
  std::vector<Index> twin;                   // 3 #F: the half-edge that runs the other way
  std::vector<Index> out;                    // #V: a half-edge that leaves the vertex
  std::vector<Index> component_of_face;      // #F
  std::vector<SurfaceComponent> components;  // by smallest face
};

// The half-edges that leave v, in the order in which the faces turn around it: counter-clockwise seen
// from outside.
std::vector<Index> half_edges_around(const SurfaceTopology& topology, Index v);

// The half-edge from a to b, or -1. O(valence).
Index find_half_edge(const TriangleMatrix& F, const SurfaceTopology& topology, Index a, Index b);

struct TopologyCheck {
  bool indices_valid = true;  // in range, three different ones in a face
  bool finite = true;
  bool closed = true;                                    // every edge has at least two faces
  bool manifold_edges = true;                            // and at most two
  bool oriented = true;                                  // which run along it in opposite directions
  bool manifold_vertices = true;                         // one fan around every vertex; every vertex is used
  std::vector<std::pair<Index, Index>> duplicate_faces;  // same three vertices
  std::vector<std::string> problems;                     // the first of each kind, one sentence each
  SurfaceTopology topology;                              // filled when ok()
  bool ok() const {
    return indices_valid && finite && closed && manifold_edges && oriented && manifold_vertices &&
           duplicate_faces.empty();
  }
};

// Looks at everything and reports all kinds of problems. O(F).
TopologyCheck check_topology(const Surface& surface);

// The adjacency, or the first problem as a bad_input error.
Result<SurfaceTopology> require_topology(const Surface& surface);

// Faces whose corners lie exactly on one line, in order. No positive tet can have such a face.
std::vector<Index> degenerate_faces(const Surface& surface);

}  // namespace overtet
