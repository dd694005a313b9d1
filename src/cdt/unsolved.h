// The error of a constrained tetrahedralization that did not come about.
#pragma once

#include <string>
#include <utility>

#include "overtet/result.h"

namespace overtet {

inline Error unsolved(std::string message) { return Error{ErrorCode::unsolved, std::move(message)}; }

}  // namespace overtet
