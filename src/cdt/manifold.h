// Tets that overlap themselves, of which TetGen has made new ones by geometry alone, may have a vertex, an
// edge or a face twice under the same numbers: tets around it that do not hang together there. That is no
// manifold. Internal to src/cdt.
#pragma once

#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {

// Takes them apart: such a vertex gets a second number, such an edge or face a vertex in its middle. What is
// on the boundary keeps its number. mesh, N: tets and their neighbours, as TetgenResult has them. Returns how
// many there were. Errors: unsolved where that is not possible with positive tets.
Result<Index> make_manifold(TetMesh& mesh, const TetMatrix& N);

}  // namespace overtet
