// Faces that are there twice, and which of them to drop.
#pragma once

#include <vector>

#include "overtet/types.h"
#include "src/cleanup/raw_edges.h"

namespace overtet {

// The faces to drop, ascending. Faces with the same three corners (in `edges.place`) are one another's
// copies; copies beside each other are one patch, and all of a patch are treated alike. Of each face stays
//
//   one copy,
//   or one of each orientation (two solids that touch in a face have it once each),
//   or all of them (solids that pass through each other may have sides in common):
//
// whatever leaves the fewest edges with an odd number of faces; where that does not decide, one copy if all
// edges of the patch then have two faces and nothing else is around it, else one of each orientation.
std::vector<Index> repeated_faces(const VertexMatrix& V, const TriangleMatrix& F, const RawEdges& edges);

// Faces to drop, ascending, that have vertices of their own but lie on other faces, corner on corner: those
// at which more edges have an odd number of faces than an even one, and what that leads to. Of each place one
// face stays.
std::vector<Index> loose_copies(const VertexMatrix& V, const TriangleMatrix& F, const RawEdges& edges);

}  // namespace overtet
