// Whether sheets of the solid can be glued along the curves in which the surface crosses itself.
//
// A positive tet mesh covers space, next to a place where the winding number is w, with w sheets; across a
// face w sheets outside go on into w of the w + 1 inside (see docs/immersion.md). Along a piece of curve
// where faces f and g cross there are four sectors, with m sheets in front of both faces, m + 1, m + 1 and m
// + 2 behind both, and four parts of faces that glue them, each the same way all over the part. One turn
// around the piece leads every sheet back to itself; the one that ends at f on one side of g ends at f on the
// other, and the same for g. Parts of faces on both sides of an edge of the input are glued alike, unless the
// edge is covered all along on its outer side; if it is, and they are not, the sheet that begins there ends
// after k turns more than the surface shows, k at most the number of times that it is covered.
//
// These conditions are necessary for any mesh. All of them are tried together, by exhaustive search; where
// they contradict each other, a few that do so by themselves are the certificate. Where that search takes too
// long, those closest to each hinge are tried by themselves: what contradicts itself is mostly there.
//
// Exact: the curves, the parts of faces and the order of sectors are found from the input's doubles with
// exact predicates and rational numbers; nothing is rounded, and no mesh is made. Only for surfaces in
// general position: where faces touch, or are coplanar where they meet, nothing is decided. Sheets over a
// region with handles may change places on the way round; how is tried like the rest. Left out is what has
// more than 6 sheets, or a hole in a face beside such a region.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "overtet/certificate.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/mesh/topology.h"

namespace overtet {

class IntersectionGraph;

enum class GluingVerdict {
  open,       // nothing contradicts a gluing
  conflict,   // there is none: no positive mesh exists
  undecided,  // not in general position, or the search is too long
};

struct GluingAnswer {
  GluingVerdict verdict = GluingVerdict::undecided;
  std::string message;         // why nothing was decided
  GluingCertificate conflict;  // of a conflict: conditions that contradict each other, few of them

  Index parts = 0;         // of faces, between the curves
  Index conditions = 0;    // of different kind
  std::int64_t steps = 0;  // of the search
};

// graph: of all intersecting pairs of the surface; prepared as far as has been needed.
// pre: every face has an area. Errors: limit or interrupted only.
Result<GluingAnswer> check_gluing(const Surface& surface, const SurfaceTopology& topology,
                                  const TriangleBvh& bvh, IntersectionGraph& graph,
                                  const RunContext& context);

}  // namespace overtet
