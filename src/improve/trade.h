// Fewer bad tets where too many are: not by lifting the worst ones, but by giving some of them up so that
// their neighbours get good. Lifting the worst tet of each star makes all tets of a star equally bad; where
// the boundary leaves no room, in thin tubes with long faces, this may be nearly all of them.
#pragma once

#include "overtet/run_context.h"
#include "src/mesh/local_operations.h"

namespace overtet {

enum class NewVertices { none, some };

// Goes over the tets that have a price, those near the goal first, until hardly anything changes: moves their
// vertices, contracts edges and, where it may, inserts vertices. Returns the number of changes.
std::int64_t fewer_bad(LocalOperations& work, const LocalOperations::Price& price, NewVertices may,
                       const RunContext& context);

}  // namespace overtet
