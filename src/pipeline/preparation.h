// The steps that make a raw surface usable, one after the other, with a clean-up before and after each.
#pragma once

#include "overtet/prepare.h"

namespace overtet {

// As prepare() in include/overtet/prepare.h, but may throw.
Result<Preparation> prepare_surface(const Surface& surface, const PrepareOptions& options,
                                    const SurfaceSource& source, const RunContext& context);

}  // namespace overtet
