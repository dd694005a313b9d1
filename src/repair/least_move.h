// How far vertices have to move at least, whatever is tried.
//
// When no vertex moves by more than d along straight lines, no point of any face does. A point further than
// d from the surface is never met on the way, so its winding number stays, and where that is negative, what
// comes out has no mesh either. The largest ball in a region of negative winding is what limits it; any ball
// there is a proof.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/diagnose.h"

namespace overtet {

struct LeastMove {
  double distance = 0;  // in the surface's unit: some vertex has to move at least so far
  Eigen::Vector3d at;   // where the winding number is negative, and no face nearer than that
};

// None: the winding number is negative nowhere, or only next to faces. The ball is a locally largest one.
// diagnosis: of the surface, complete, with its tree.
std::optional<LeastMove> least_move(const Surface& surface, const Diagnosis& diagnosis,
                                    const RunContext& context);

}  // namespace overtet
