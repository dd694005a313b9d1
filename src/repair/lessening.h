// Moving less, from any repaired surface: what has been moved goes back towards its places as far as nothing
// objects.
//
// Connected groups of moved vertices are looked at by themselves, many at the same time: all of a group home;
// its largest moves cut back to one length; all its moves shortened by one factor; its vertices home, the
// smallest moves first; its vertices half of the way home, the largest moves first. What has been refused is
// tried in halves, down to single vertices. All moves are along the straight ways home.
//
// Guaranteed: no vertex ends further from its place than it began; the diagnosis of the result objects to
// nothing if it objected to nothing before; no face gets thinner than kThinnest (in lessening.cpp) that was
// not so before. Same bytes on any number of threads.
#pragma once

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct LessenOptions {
  // Pairs of faces (plus a hundredth of the faces) looked at. Counted, not timed: the same on every machine.
  double work = 3e4;

  Status validate() const;
};

struct LessenResult {
  VertexMatrix V;
  Index looks = 0;        // diagnoses spent
  bool lessened = false;  // V is not what it was
  bool cut_by_time = false;
};

// input: the surface that was repaired; moved: its vertices after that, to which the diagnosis does not
// object (else nothing is done). Where the deadline passes, what has been reached by then is the result.
// Errors: bad_input (not closed, oriented, manifold), interrupted, usage.
Result<LessenResult> lessen(const Surface& input, const VertexMatrix& moved, const LessenOptions& options,
                            const RunContext& context);

}  // namespace overtet
