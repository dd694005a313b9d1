// Faces that have no area as far as rounded coordinates can tell.
#pragma once

#include <vector>

#include "overtet/types.h"

namespace overtet {

// Those whose height is at most `relative` times their largest coordinate in absolute value (or `reach`, if
// that is more), in order. Decided in doubles: degenerate_faces() (topology.h) is the exact question.
std::vector<Index> flat_faces(const Surface& surface, double relative, double reach = 0);

}  // namespace overtet
