// Whether a mesh or a surface can be shown: indices in range, finite coordinates, arrays of the right sizes.
// Internal to src/view.
#pragma once

#include "overtet/attributes.h"
#include "overtet/result.h"

namespace overtet::view {

Status check(const LabelledTetMesh& mesh);  // errors: bad_input
Status check(const Surface& surface, const SurfaceAttributes& attributes);

}  // namespace overtet::view
