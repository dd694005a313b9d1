// Links of vertices: what a small sphere around a vertex of the arrangement shows of the copies of cells.
#pragma once

#include <vector>

#include "overtet/types.h"
#include "src/immersion/edge_fan.h"

namespace overtet {

// The facets through the vertex cut the sphere into sectors, each covered as often as its cell.
struct VertexLink {
  struct Arc {  // a facet
    Index region;
    bool flipped;
    int front, back;  // sectors; -1: not covered
  };
  std::vector<Index> winding;  // per sector
  std::vector<Arc> arcs;
  std::vector<Fan> corners;  // edges of the arrangement at the vertex
  int rest = 0;              // of the Euler characteristic: all but the corners
  // Only where edges may be wound: closed polygons of what ends at the vertex; per corner and pass of its
  // fan, the number of the free edge, or -1.
  int borders = 0;
  std::vector<std::vector<Index>> edges;
};

// Whether the copies make spheres (where they do not end at the vertex) and discs: what vertices of a solid
// need. Fans only see edges: a disc that turns twice at its border, and a handle that does, look the same to
// them. chosen: per region, its gluing. Fans need not be satisfied: what hangs together around a
// corner is one point of the link, however often it turns there.
bool makes_discs(const VertexLink& link, const std::vector<const Gluing*>& chosen,
                 const std::vector<Region>& regions);

}  // namespace overtet
