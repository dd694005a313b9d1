#include "src/cli/commands.h"

namespace overtet {

int run(const InspectCommand&, const CommonOptions&, Terminal& terminal) {
  return fail(terminal, {ErrorCode::internal, "inspect waits for the diagnosis."});
}

}  // namespace overtet
