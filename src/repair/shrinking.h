// Moving less: what a repair has moved goes back as far as nothing objects. Internal to src/repair.
#pragma once

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/repair/clusters.h"

namespace overtet {

// First every cluster less far, then fewer vertices. What is tried at the same time in different clusters is
// judged cluster by cluster. pre: base with the clusters' moves is feasible; so it is afterwards.
// Returns the number of diagnoses spent.
Result<Index> shrink(Clusters& clusters, const Surface& input, const VertexMatrix& base,
                     const VertexRings& rings, double diagonal, const RepairOptions& options,
                     const RunContext& context);

}  // namespace overtet
