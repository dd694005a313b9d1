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

// By all means: with dear means from the beginning, for any gain.
enum class Care { usual, by_all_means };

// fresh: of the first vertices; tets without one are known to have resisted and left alone until something at
// their corners changes. Empty: all vertices are.
// For at most `seconds`; time_over also when the context says stop.
PassesResult improve_passes(LocalOperations& work, std::span<const char> fresh, const ImproveOptions& options,
                            Care care, double seconds, const RunContext& context);

}  // namespace overtet
