// Reading VTU. Internal to src/io.
#pragma once

#include <string_view>

#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {

Result<TetMesh> read_vtu(std::string_view name, std::string_view bytes);

}  // namespace overtet
