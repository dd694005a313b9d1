// Of the cells of the arrangement those that the surface winds around, as one mesh: nothing is there twice.
// This is what others make of a surface that passes through itself [Jacobson, Kavan, Sorkine-Hornung 2013].
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct FusedCells {
  TetMesh mesh;                                // surface_vertices: those of the boundary, which come first
  std::vector<std::array<Index, 3>> boundary;  // outward
  std::vector<Index> input_face;               // of each of these, the surface's face
  std::vector<Index> input_vertex;             // #V; the surface's (the smallest in that place), or -1
};

// As mesh_cells(); bad_input where nothing has a positive winding number.
Result<FusedCells> fuse_cells(const Surface& surface, const std::vector<std::pair<Index, Index>>& pairs,
                              const RunContext& context);

}  // namespace overtet
