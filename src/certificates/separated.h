// Components that touch each other, or lie in one place, and one of which has no mesh by itself.
//
// A mesh of positive tets still is one after all small moves of its vertices. So if a surface has a mesh, it
// has one as well when one of its components moves by eps d, for every small enough eps > 0. For nearly every
// direction d nothing touches any more, and all that wound_edges.h says applies. There the rest of the
// surface counts only by its winding numbers just beside points of the component: at x what it is at x + eps
// d. Where they leave an odd group of hinges of the component as it is, there is no mesh of the whole. (What
// is wrong at a single point needs no moves: shared_points.h.)
#pragma once

#include <optional>
#include <vector>

#include "overtet/certificate.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/covering/hinges.h"
#include "src/mesh/topology.h"

namespace overtet {

// None where nothing forbids a mesh like that. Looks at components with a hinge whose integer is not defined.
// hinges: of the whole surface. Errors: limit or interrupted.
Result<std::optional<SeparatedCertificate>> find_separated_part(const Surface& surface,
                                                                const SurfaceTopology& topology,
                                                                const std::vector<Hinge>& hinges,
                                                                const RunContext& context);

}  // namespace overtet
