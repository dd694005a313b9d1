// No two vertices in one place.
//
// In a mesh that overlaps itself vertices of different layers may lie in exactly the same place: harmless
// here, where neighbours are neighbours in the complex, but many programs that read a mesh merge equal
// points, and glue the layers. So vertices inside step aside by a hair. Vertices of the surface stay where
// they are.
#pragma once

#include <cstdint>

#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct SetApartResult {
  std::int64_t moved = 0;         // vertices that have stepped aside
  std::int64_t stuck = 0;         // that found no room
  std::int64_t forced = 0;        // vertices of the surface in one place with another one of the surface
  Index first = -1, second = -1;  // two of these
};

// Afterwards every vertex inside is farther than kApart times the mean length of its edges from every other
// vertex, where there is room for that. Every tet that was exactly positive is so again; angles get worse by
// a hair at most, or else only where vertices coincide exactly. Vertices that are far enough from others stay
// as they are, to the last bit. The same result on any number of threads. pre: every tet is positive.
SetApartResult set_apart(TetMesh& mesh, const RunContext& context);

}  // namespace overtet
