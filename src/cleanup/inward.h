// Which components face inwards though they are no cavities.
//
// A component faces inwards where its own winding number is negative in places and positive in none; exactly.
// (Looked for by the sign of its volume, and, if the component passes through itself, by a search over the
// pieces of its curves.) It is a cavity, and stays as it is, where the winding number of all other components
// is 1 or more at each of its vertices (those that lie on other components are not asked). Components are
// looked at from the outside in: one whose box is larger first, and those that come later know how the
// earlier ones have been turned. One that faces outwards is turned where it was the hole of what has been
// turned: where the others' winding number was negative at its vertices, and is 1 or more now. So a whole
// model that faces inwards is turned with its cavities, and of two components the one that is at fault.
//
// A surface with a winding number that is nowhere negative is never changed: beside a vertex of a component
// that faces inwards its own winding number is -1 or less, so that the others' is 1 or more there.
#pragma once

#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// The components to turn, ascending. component_of: of each face; 0 ... components - 1.
// pre: the surface is closed, oriented, manifold. Errors: limit, interrupted.
Result<std::vector<Index>> inward_components(const Surface& surface, const std::vector<Index>& component_of,
                                             Index components, const RunContext& context);

}  // namespace overtet
