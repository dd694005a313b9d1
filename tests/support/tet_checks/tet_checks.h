// What every tet mesh of this project must be, checked by looking at all of it.
#pragma once

#include <array>
#include <set>

#include "src/mesh/tet_complex.h"

namespace overtet::test {

using FaceSet = std::set<std::array<Index, 3>>;

// The boundary faces with their smallest corner first, orientation kept.
FaceSet boundary_faces(const TetComplex& c);

// Exactly positive tets; faces of two tets have opposite orientation; no two tets, faces or edges with
// the same corners; vertex links are one sphere or one disc; one turn around every interior edge.
// Fails the running test with what it finds.
void expect_valid(const TetComplex& c);

}  // namespace overtet::test
