// Builds the abstract solid from the sheets: one tet per copy of every tet, glued, with the surface's own
// vertex numbers, as a simplicial complex. It is immersed (all positive, one turn around every interior
// edge), and its boundary is the surface cut along its intersection curves.
#pragma once

#include <array>
#include <vector>

#include "overtet/result.h"
#include "src/immersion/sheets.h"

namespace overtet {

struct Cover {
  TetMesh mesh;           // the first surface_vertices rows are the surface's vertices, so many
  Index free_points = 0;  // that follow are copies of TetgenResult's free points
  TetMatrix neighbours;   // #T x 4; as TetComplex has them
  std::vector<std::array<Index, 3>> boundary;  // boundary triangles, outward
  std::vector<Index> face;                     // the input face that each lies on
  Index split_edges = 0;  // edges halved because another edge had the same two end vertices
};

// Errors: unsolved when copies of different surface vertices are glued (naming them).
Result<Cover> build_cover(const Surface& surface, const Arrangement& arrangement, const TetgenResult& tets,
                          const Sheets& sheets, const RunContext& context);

}  // namespace overtet
