// The steps that are more than joining borders. Each changes the surface and says what it did; messages are
// made by who calls them. Errors: limit, interrupted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "overtet/prepare.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/prepare/working_surface.h"

namespace overtet {

struct StepOutcome {
  std::int64_t done = 0, left = 0;
  std::vector<Figure> figures;
  std::vector<PlaceLeft> places;  // vertices are numbers of the working surface; the first most_places
};

// Components: faces that have a vertex in common.
StepOutcome drop_components(WorkingSurface& working, Index fewest_faces, bool largest_only);

Result<StepOutcome> fill_holes(WorkingSurface& working, const PrepareOptions& options,
                               const RunContext& context);

// length: that the surface may move.
Result<StepOutcome> collapse_needles(WorkingSurface& working, const PrepareOptions& options, double length,
                                     const RunContext& context);

}  // namespace overtet
