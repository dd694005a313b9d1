// A surface that has a tet mesh, near one that has none. docs/repair.md says how it is found.
#pragma once

#include <vector>

#include "overtet/report.h"
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
  double max_relative_move = 0, mean_relative_move = 0;  // relative to the diagonal; the mean of those moved
};

// Moves a few vertices a little, so that a tet mesh exists (one was made and checked; tetrahedralize() with
// OnInfeasible::repair keeps it). A surface that has one comes back as it is. Guaranteed: no vertex moves
// farther than max_relative_move, the faces stay, the same input gives the same result on any number of
// threads. That few vertices move, and little, is the aim but not guaranteed. Errors: as of tetrahedralize();
// where larger moves would do, the message says how large. Never throws. report: as tetrahedralize() fills
// it.
Result<SurfaceRepair> repair_surface(const Surface& surface, const SurfaceRepairOptions& options = {},
                                     const RunContext& context = {}, Report* report = nullptr);

}  // namespace overtet
