// Where the program is that runs TetGen.
#pragma once

#include <string>

#include "overtet/result.h"
#include "overtet/run_context.h"

namespace overtet {

// The path of an executable file: context.tetgen_helper if that is set; otherwise the first of overtet-tetgen
// beside the running program (as in a build tree), in the libexec folder of the program's or of the shared
// library's installation, where it was to be installed, and where packages put it. Errors: internal.
Result<std::string> tetgen_helper(const RunContext& context);

}  // namespace overtet
