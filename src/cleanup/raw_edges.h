// Which half-edges of a triangle soup lie on one edge. Half-edge h = 3 f + k of face f runs from F(f, k) to
// F(f, (k + 1) % 3), as everywhere (src/mesh/topology.h).
#pragma once

#include <vector>

#include "overtet/types.h"

namespace overtet {

// Half-edges of one edge: list[begin] ... list[begin + count - 1], ascending.
struct EdgeGroup {
  Index begin = 0, count = 0;
};

struct RawEdges {
  std::vector<Index> list;
  std::vector<Index> partner;     // 3 #F: the other half-edge of an edge that has two, else -1
  std::vector<EdgeGroup> others;  // edges of one face, and of more than two; by position in the list
  // #V: vertices that may become one have one number, the smallest of theirs: those in one place that are
  // ends of edges with an odd number of faces. All others have their own.
  std::vector<Index> place;
  bool merges = false;  // whether two vertices have one number in `place`
};

// An edge is given by its two vertices; edges of which the number of faces is odd are then put together where
// their ends are in the same two places; but not an edge of one face with that of the same face once more.
// pre: indices valid, V finite. O(#F) but for sorting the edges at each vertex, and odd edges.
RawEdges find_edges(const VertexMatrix& V, const TriangleMatrix& F);

// Whether the half-edge runs from the smaller of the edge's two numbers in `place` to the larger one.
bool runs_up(const TriangleMatrix& F, const std::vector<Index>& place, Index h);

}  // namespace overtet
