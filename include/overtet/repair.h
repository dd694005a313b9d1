// A surface that has a tet mesh, near one that has none.
#pragma once

#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct SurfaceRepairOptions {
  double max_relative_move = 0.06;  // of a vertex, relative to the diagonal of the bounding box; up to 1
};

struct SurfaceRepair {
  Surface surface;           // with the same faces
  std::vector<Index> moved;  // sorted; all other vertices are as they were, to the last bit
  double max_relative_move = 0, mean_relative_move = 0;  // over the diagonal; the mean of those that moved
};

// Moves a few vertices a little, so that a tet mesh exists (one was made and checked; tetrahedralize() with
// OnInfeasible::repair keeps it). A surface that has one comes back as it is. Few vertices and small moves
// are the aim, not a guarantee; the largest move is one. Errors: as of tetrahedralize(); where larger moves
// would do, the message says how large. Never throws.
Result<SurfaceRepair> repair_surface(const Surface& surface, const SurfaceRepairOptions& options = {},
                                     const RunContext& context = {});

}  // namespace overtet
