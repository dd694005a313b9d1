#include "overtet/embed.h"

#include <exception>

#include "src/pipeline/embedding.h"
#include "src/run/exceptions.h"

namespace overtet {

Status EmbedOptions::validate() const {
  if (!(gap > 0 && gap <= 10))
    return Error{ErrorCode::usage, "The gap must be more than 0 and at most 10 diagonals."};
  return success();
}

Result<Embedding> embed(const Surface& surface, const EmbedOptions& options, const RunContext& context,
                        Report* report) {
  try {
    Report unread;
    return embed_surface(surface, options, context, report ? *report : unread);
  } catch (const std::exception&) {
    return error_of_exception();
  }
}

}  // namespace overtet
