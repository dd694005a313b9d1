// The passes of the quality improvement over one complex; see improve.h.
#pragma once

#include <vector>

#include "src/improve/improve.h"
#include "src/tet_complex/local_operations.h"

namespace overtet {

struct PassesResult {
  ImproveResult::End end = ImproveResult::End::passes_done;
  std::vector<ImprovePass> passes;
};

// by_all_means: dear ones from the beginning, for any gain. For at most `seconds`; time_over also when the
// context says stop.
PassesResult improve_passes(LocalOperations& work, const ImproveOptions& options, bool by_all_means,
                            double seconds, const RunContext& context);

}  // namespace overtet
