// Every stage works in a unit box around the origin: the surface is scaled by a power of two on entry, and
// the result is scaled back exactly on exit, so the input's vertices come out as they went in.
//
// All axes are scaled alike, unless the model is thousands of times longer than thick: then each axis
// gets its own power of two. That keeps what counts (crossings, signs of volumes, turns around edges are
// affine invariants) and lets the mesh generator work on a model of ordinary shape.
#pragma once

#include <array>

#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {

struct UnitBox {
  std::array<int, 3> exponent{};  // coordinate k was multiplied by 2^exponent[k]
  bool uniform() const { return exponent[0] == exponent[1] && exponent[1] == exponent[2]; }
};

// Scales V so that the largest coordinate is in [1/2, 1). Errors: unsolved for coordinates whose bits
// would be lost by the scaling, and for surfaces that lie in an axis-parallel plane.
Result<UnitBox> into_unit_box(VertexMatrix& V);
void out_of_unit_box(VertexMatrix& V, const UnitBox& box);
void back_into_unit_box(VertexMatrix& V, const UnitBox& box);  // undoes out_of_unit_box

}  // namespace overtet
