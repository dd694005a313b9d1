// The passes of the quality improvement over one complex; see improve.h.
#pragma once

#include <span>
#include <vector>

#include "src/improve/improve.h"
#include "src/mesh/local_operations.h"

namespace overtet {

struct PassesResult {
  ImproveResult::End end = ImproveResult::End::passes_done;
  std::vector<ImprovePass> passes;
};

// fresh: of the first vertices; tets without one are known to have resisted and left alone until something at
// their corners changes. Empty: all vertices are. by_all_means: dear means from the beginning, for any gain.
// For at most `seconds`; time_over also when the context says stop.
PassesResult improve_passes(LocalOperations& work, std::span<const char> fresh, const ImproveOptions& options,
                            bool by_all_means, double seconds, const RunContext& context);

}  // namespace overtet
