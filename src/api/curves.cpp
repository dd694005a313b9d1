#include "overtet/curves.h"

#include "src/api/guarded.h"
#include "src/arrangement/curves.h"
#include "src/arrangement/intersection_graph.h"
#include "src/exact/ordinary_size.h"

namespace overtet {

Result<Curves> intersection_curves(const Surface& surface, const RunContext& outer) {
  return guarded(outer, [&](const RunContext& context) -> Result<Curves> {
    const Result<SurfaceTopology> topology = require_topology(surface);
    if (!topology) return topology.error();
    if (const std::vector<Index> flat = degenerate_faces(surface); !flat.empty())
      return Error{ErrorCode::bad_input, "Face " + std::to_string(flat[0]) + " has no area."};
    TriangleBvh bvh;
    bvh.build(surface.V, surface.F);
    const std::vector<FacePair> pairs = find_self_intersections(surface.V, surface.F, bvh);
    if (auto stop = context.stop()) return *stop;
    const OrdinarySize sized(surface, bvh);
    IntersectionGraph graph(sized.surface(), topology.value(), sized.bvh(), pairs);
    return trace_curves(surface, bvh, graph, context);
  });
}

}  // namespace overtet
