// Which parts of a surface to turn, and how. Internal to src/repair.
#pragma once

#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/repair/offences.h"
#include "src/repair/repair.h"
#include "src/repair/turning.h"

namespace overtet {

struct TurnedSurfaces {
  std::vector<VertexMatrix> V;  // ways of turning its parts, the best first
  Index parts = 0;              // turned
  Index looks = 0;              // diagnoses spent
};

// Turns parts that are inside out as a whole, as long as that leaves much less to object to. found: of the
// input. thin: walls closer than this are not worth turning.
Result<TurnedSurfaces> turn_parts(const Surface& input, const Findings& found, const VertexRings& rings,
                                  double diagonal, double thin, const RepairOptions& options,
                                  const RunContext& context);

}  // namespace overtet
