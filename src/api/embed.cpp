#include "overtet/embed.h"

#include "src/pipeline/embedding.h"

namespace overtet {

Result<Embedding> embed(const Surface& surface, const EmbedOptions& options, const RunContext& context,
                        Report* report) {
  try {
    Report unread;
    return embed_surface(surface, options, context, report ? *report : unread);
  } catch (...) {
    return error_of_exception();
  }
}

}  // namespace overtet
