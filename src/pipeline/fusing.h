// The mesh that others make: the cells that the surface winds around, improved, with what is known of them.
#pragma once

#include "overtet/fused.h"

namespace overtet {

// As fused_mesh() in include/overtet/fused.h, but may throw.
Result<FusedMesh> fuse_surface(const Surface& surface, const SurfaceAttributes& attributes,
                               const FusedOptions& options, const RunContext& context);

}  // namespace overtet
