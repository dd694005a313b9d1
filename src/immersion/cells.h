// The arrangement in its tet mesh: facets, the cells between them, and how many times the solid covers each.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "overtet/result.h"
#include "overtet/types.h"
#include "src/arrangement/arrangement.h"
#include "src/cdt/tetgen.h"
#include "src/immersion/sheets.h"

namespace overtet {

// Fills facet_on, facets (but their regions), cell, winding and cuts. Returns per facet its corners in the
// orientation of its arrangement triangle, so that its front is where their normal points to.
// Errors: unsolved when the winding numbers do not agree, or when one is negative.
Result<std::vector<std::array<Index, 3>>> find_cells(const Arrangement& arrangement, const TetgenResult& tets,
                                                     Sheets& sheets);

}  // namespace overtet
