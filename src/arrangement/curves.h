// Tracing the curves in which a surface passes through itself; what they are and what is exact about them is
// in overtet/curves.h. Pairs of faces meet in segments (intersection_graph.h). The edge in which one ends
// leads to the next pair: so segments are strung together by (edge, face), never by how close their ends are.
#pragma once

#include <vector>

#include "kernels/bvh/bvh.h"
#include "overtet/curves.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

class IntersectionGraph;

// graph: of all intersecting pairs of the surface; prepared as far as has been needed.
// Errors: limit or interrupted only.
Result<Curves> trace_curves(const Surface& surface, const TriangleBvh& bvh, IntersectionGraph& graph,
                            const RunContext& context);

}  // namespace overtet
