// Faces that take the place of others, if they do no harm.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/prepare/working_surface.h"

namespace overtet {

struct Patch {
  std::vector<Index> old_faces;         // that go, ascending
  std::vector<Eigen::Vector3d> points;  // new vertices, finite
  // Corners: a vertex of the surface, or -1 - i for points[i].
  std::vector<std::array<Index, 3>> faces;
  std::vector<Index> face_of;  // of each face: the given surface's, -1: new
};

enum class PatchFate {
  taken,
  flat,      // a face has no area
  crowded,   // an edge would have three faces or more
  crossing,  // it crosses or touches itself, what is there, or a patch before it
};

// Puts into the surface every patch that does no harm; where two of them do only together, the first one.
// What the old faces crossed already may be crossed still. New faces come last; vertices keep their numbers,
// even those that no face uses now. pre: no face is an old one of two patches. allow_crossings: only flat and
// crowded ones are left out. Near-linear in the size of surface and patches. Errors: limit, interrupted.
Result<std::vector<PatchFate>> put_patches(WorkingSurface& working, const std::vector<Patch>& patches,
                                           bool allow_crossings, const RunContext& context);

}  // namespace overtet
