// One place of opening.h: a part of the mesh by itself.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "overtet/run_context.h"
#include "src/mesh/partition.h"
#include "src/opening/opening.h"

namespace overtet {

struct HomeOfMoved {
  Index vertex;  // of the part's complex
  Eigen::Vector3d home;
};

// Changes the part; it stays as it was where that is not worthwhile. moved: not empty.
OpenedPlace open_place(MeshPart& part, const std::vector<HomeOfMoved>& moved, const OpeningOptions& options,
                       const RunContext& context);

}  // namespace overtet
