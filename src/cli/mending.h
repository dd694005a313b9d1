// What would mend what `inspect` finds: one sentence each.
#pragma once

#include <string>

#include "overtet/cleanup.h"
#include "overtet/diagnosis.h"

namespace overtet {

// refused: the clean-up gave up on the surface, because of this defect or another one.
std::string mend_of(const Defect& defect, bool refused);
std::string mend_of_flat_faces();
std::string mend_of_thin_spots();

}  // namespace overtet
