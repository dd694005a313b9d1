// The tet mesh of all cells of the arrangement at once: what the layers are glued from.
#pragma once

#include <utility>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/arrangement/arrangement.h"
#include "src/cdt/tetgen.h"

namespace overtet {

struct CellMeshOptions {
  double radius_edge = 2;  // circumradius over shortest edge, where TetGen needs points inside; 0: no bound
  double patience = 1;     // with TetGen; src/cdt/tetgen.h
  double tolerance = 0;    // of the arrangement; 0: exact
};

struct CellMesh {
  Arrangement arrangement;
  TetgenResult tets;  // facet_markers: the arrangement's triangle + 1
  double arrangement_seconds = 0, tet_mesh_seconds = 0;
};

// pairs: all intersecting pairs of faces. Errors: those of arrange() and tetrahedralize_stubbornly().
Result<CellMesh> mesh_cells(const Surface& surface, const std::vector<std::pair<Index, Index>>& pairs,
                            const CellMeshOptions& options, const RunContext& context);

// Those to try, in this order.
std::vector<double> arrangement_tolerances(const Surface& surface,
                                           const std::vector<std::pair<Index, Index>>& pairs);

}  // namespace overtet
