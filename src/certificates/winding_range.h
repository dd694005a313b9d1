// A point of negative winding number, wherever one exists, and the range of the winding number.
//
// The surface's intersection curves cut it into patches, and the winding number is constant on the outer
// side of a patch. Every region of space has a patch on its border, so its number is that of the outer
// side (w) or the inner side (w + 1) of some patch; the smallest one is on an outer side. A patch either
// borders on a curve piece, where the wedge in front of both crossing faces shows its number, or is a
// whole component, where any point in front of it does. So one exact ray for every curve piece (a pair's
// segment, cut where third faces cross it) and one for every component decide the matter: no sampling, no
// luck, however small the region. Where a wedge is negative the ray is followed half-way to its next
// crossing, which gives the point; its winding number is computed once more on its own.
#pragma once

#include <optional>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/certificate.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/mesh/topology.h"

namespace overtet {

class IntersectionGraph;

struct WindingRange {
  int min = 0, max = 0;                       // over all of space (0 far away included)
  Index negative_pairs = 0;                   // pairs with a curve piece where the outer wedge is negative
  std::optional<WindingCertificate> witness;  // exists exactly when min < 0
  std::vector<FacePair> negative_at;          // those pairs, sorted; (-1, -1): a component by itself
  Index touching_pairs = 0;                   // pairs that have a point in common only: no curve piece
  Index undecided_pairs = 0;  // curve pieces at which no ray could be counted (not seen so far)
  bool complete = true;       // false: the search ended at the first negative wedge
};

struct WindingRangeOptions {
  bool stop_at_first_negative = false;  // a witness is enough; min and max then are bounds only
};

// graph: of all intersecting pairs of the surface; prepared as far as has been needed.
// pre: no face without area.
Result<WindingRange> find_winding_range(const Surface& surface, const SurfaceTopology& topology,
                                        const TriangleBvh& bvh, IntersectionGraph& graph,
                                        const RunContext& context, const WindingRangeOptions& options = {});

}  // namespace overtet
