// Every stage works in a unit box around the origin: the surface is scaled by a power of two on entry, and
// the result is scaled back exactly on exit, so the input's vertices come out as they went in.
#pragma once

#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {

struct UnitBox {
  int exponent = 0;  // coordinates were multiplied by 2^exponent
};

// Scales V so that the largest coordinate is in [1/2, 1). Errors: bad_input for coordinates so large or so small
// that volumes would overflow or underflow, or whose bits would be lost by the scaling.
Result<UnitBox> into_unit_box(VertexMatrix& V);
void out_of_unit_box(VertexMatrix& V, const UnitBox& box);

}  // namespace overtet
