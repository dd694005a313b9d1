// Surfaces and shared steps for the tests of the immersion stage. Nothing here comes from a file.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "overtet/verification.h"
#include "src/arrangement/arrangement.h"
#include "src/cdt/tetgen.h"
#include "src/certificates/diagnose.h"
#include "src/immersion/immersion.h"
#include "src/immersion/sheets.h"
#include "tests/support/models.h"

namespace overtet::test {

// A closed tube along a (2, 3) torus knot whose two strands overlap all the way: the doubly covered cell
// is a solid torus, and after one time around it the two copies have changed places. No hinges.
Surface thick_knot(int along = 60, int across = 8);

// A capsule along a random smooth curve of about constant curvature, so that long ones run through
// themselves. What happens (hinges, negative winding, nothing at all) depends on the seed.
Surface random_worm(std::uint64_t seed, int around = 8);

// The elbow with a small sphere around one end of its longest chain of wound edges, so that every such chain
// must pass through the sphere's surface.
Surface pierced_elbow();

// What the pipeline does before it calls the stage.
Diagnosis diagnosed(const Surface& s);

// Everything up to the sheets.
struct Prepared {
  Surface surface;
  Diagnosis diagnosis;
  Arrangement arrangement;
  TetgenResult tets;
};
Prepared prepared(const Surface& s);

// Runs the whole stage and the exact check; an empty string or what is wrong.
std::string failure_of(const Surface& s, ImmersionResult* out = nullptr, double radius_edge = 2);
// The exact check of a mesh alone.
std::string check(const Surface& s, const TetMesh& mesh);

}  // namespace overtet::test
