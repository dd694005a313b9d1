// What is said about defects.
#pragma once

#include <string>

#include "overtet/cleanup.h"
#include "overtet/io.h"

namespace overtet {

// Why the surface cannot be cleaned, or (of what could be mended) needs it: one sentence with the first
// place, in numbers of the file, and with how many more there are.
std::string explain(const Defect& defect, const Surface& surface, const SurfaceSource& source);

}  // namespace overtet
