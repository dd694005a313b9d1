// Which facet of a complex lies on each face of its tets.
#pragma once

#include <array>
#include <vector>

#include "src/cdt/tetgen.h"

namespace overtet {

// As TetgenResult::facet_on, for where that was not found out by the way: #T, the row of `facets` on the face
// opposite to each vertex, or -1.
std::vector<std::array<Index, 4>> facets_on_faces(const TetgenResult& tets);

}  // namespace overtet
