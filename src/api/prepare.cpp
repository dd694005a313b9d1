#include "overtet/prepare.h"

#include "src/api/guarded.h"
#include "src/pipeline/preparation.h"

namespace overtet {

Result<Preparation> prepare(const Surface& surface, const PrepareOptions& options,
                            const SurfaceSource& source, const RunContext& outer) {
  if (Status valid = options.validate(); !valid) return valid.error();
  return guarded(
      outer, [&](const RunContext& context) { return prepare_surface(surface, options, source, context); });
}

}  // namespace overtet
