// What forbids a mesh of a surface, as groups of vertices that could be moved. Internal to src/repair.
#pragma once

#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/diagnose.h"
#include "src/repair/smoothing.h"

namespace overtet {

// Vertices that forbid a mesh together, sorted.
using Offence = std::vector<Index>;

struct Findings {
  Diagnosis diagnosis;
  std::vector<Offence> offences;
  bool hopeless = false;  // a component that faces inwards with nothing around it
};

// How much of what pokes out where the winding number is negative belongs to an offence.
enum class PokingOut {
  pairs,  // the corners of the two faces where it was seen
  all     // all vertices around them in front of which the winding number is negative, too
};

// What the diagnosis of a surface objects to. diagnosis: complete, with the whole winding range, or ended
// where a face has no area. Errors: bad_input.
Result<Findings> offences_of(const Surface& surface, Diagnosis diagnosis, const VertexRings& rings,
                             double diagonal, PokingOut poking_out);

// The diagnosis of a surface, and what it objects to: faces without area, pairs of faces at which the winding
// number is negative, vertices. diagonal: of the surface's box, roughly.
// Errors: bad_input (not closed, oriented, manifold), limit, interrupted.
Result<Findings> find_offences(const Surface& surface, const VertexRings& rings, double diagonal,
                               PokingOut poking_out, const RunContext& context);

// Whether two sorted lists have something in common.
bool sorted_share(const std::vector<Index>& a, const std::vector<Index>& b);

}  // namespace overtet
