// The immersion stage: from a surface that passes through itself straight to a tet mesh of the solid it
// bounds, without any flow.
//
//   1. arrangement: cut the surface along its own intersections, exactly;
//   2. tet mesh of all cells of the arrangement at once (TetGen keeps every triangle);
//   3. sheets: winding-number many copies of every cell, glued so that nothing branches;
//   4. cover: the immersed solid as a simplicial complex;
//   5. boundary points: the points that cutting added are moved inside, so the boundary is the input again.
//
// The result is exactly positive by construction. Hinges need no special treatment: the sheets
// know them. Where the paper's way (flows and a volumetric map, Sacht et al. 2013, sections 3 and 4) has to
// find the overlap by optimisation, and locks, here it is read off the winding numbers; the price is a finer
// mesh along the intersection curves.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/arrangement/arrangement.h"
#include "src/covering/wound_edges.h"

namespace overtet {

struct ImmersionOptions {
  // Circumradius over shortest edge, where TetGen needs points inside (the quality pass makes them faster).
  double radius_edge = 2.0;
  double patience = 1;  // with TetGen; src/cdt/tetgen.h

  Status validate() const;
};

// More than 12 members: a record of figures beside the mesh.
struct ImmersionResult {
  TetMesh mesh;           // boundary = the input surface
  Index free_points = 0;  // the vertices that follow the surface's: copies of TetgenResult's
  Arrangement arrangement;
  TetMesh cover;  // before the boundary points were moved inside
  Index cells = 0, regions = 0, constraints = 0;
  Index winding_max = 0;
  std::int64_t search_nodes = 0;
  Index steiner_points = 0;  // that the mesh of the cells has beside those of the arrangement
  Index missing_facets = 0, tetgen_facets = 0, tetgen_parts = 0;  // src/cdt/tetgen.h
  Index boundary_points = 0;                                      // moved inside
  Index refined_edges = 0;
  double smallest_clearance = 0;
  double arrangement_seconds = 0, tet_mesh_seconds = 0, sheets_seconds = 0, boundary_seconds = 0;
};

// pairs: all intersecting pairs of faces; wound: src/covering/wound_edges.h.
// Errors: unsolved (with the place, and ErrorReason::exhausted where no way of gluing is left), limit,
// interrupted.
Result<ImmersionResult> immerse(const Surface& surface, const std::vector<std::pair<Index, Index>>& pairs,
                                std::span<const WoundEdge> wound, const ImmersionOptions& options,
                                const RunContext& context);

}  // namespace overtet
