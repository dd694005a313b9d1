// The embedding of a surface as a result of its own: the flows of the flow route, without a mesh.
#pragma once

#include "overtet/embed.h"

namespace overtet {

// As embed() in include/overtet/embed.h, but may throw (bad_alloc, of the watch over the run).
Result<Embedding> embed_surface(const Surface& surface, const EmbedOptions& options,
                                const RunContext& context, Report& report);

}  // namespace overtet
