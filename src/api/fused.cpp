#include "overtet/fused.h"

#include "src/api/guarded.h"
#include "src/pipeline/fusing.h"

namespace overtet {

Status FusedOptions::validate() const {
  if (improve_degrees >= 0 && improve_degrees <= 40) return success();
  return Error{ErrorCode::usage, "The smallest dihedral angle to aim at must lie between 0 and 40 degrees."};
}

Result<FusedMesh> fused_mesh(const Surface& surface, const SurfaceAttributes& attributes,
                             const FusedOptions& options, const RunContext& outer) {
  if (Status valid = options.validate(); !valid) return valid.error();
  return guarded(
      outer, [&](const RunContext& context) { return fuse_surface(surface, attributes, options, context); });
}

}  // namespace overtet
