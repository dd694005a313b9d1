// Where the program is that runs TetGen.
#pragma once

#include <string>

#include "overtet/result.h"
#include "overtet/run_context.h"

namespace overtet {

// The path of an executable file: context.tetgen_helper if that is set; otherwise where helper_program()
// finds overtet-tetgen. Errors: io.
Result<std::string> tetgen_helper(const RunContext& context);

}  // namespace overtet
