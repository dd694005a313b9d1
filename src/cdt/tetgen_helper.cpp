#include "src/cdt/tetgen_helper.h"

#include "src/run/helper_program.h"

namespace overtet {

Result<std::string> tetgen_helper(const RunContext& context) {
  if (!context.tetgen_helper.empty()) {
    if (can_run(context.tetgen_helper)) return context.tetgen_helper;
    return Error{ErrorCode::io, "Cannot run the program overtet-tetgen as " + context.tetgen_helper +
                                    "; TetGen runs in it."};
  }
  if (const std::optional<std::string> path = helper_program("overtet-tetgen")) return *path;
  return Error{ErrorCode::io,
               "The program overtet-tetgen, in which TetGen runs, is missing: put it into the folder " +
                   program_folder() + ", beside the program, or install Overtet again."};
}

}  // namespace overtet
