// Delaunay refinement of the inside: circumcentres of badly shaped tets become vertices, so that what comes
// after has vertices to work with. Shewchuk, "Tetrahedral mesh generation by Delaunay refinement" (1998); the
// boundary is never split: a centre that encroaches upon it is left out.
#pragma once

#include <cstdint>

#include "overtet/run_context.h"
#include "src/tet_complex/local_operations.h"

namespace overtet {

// Every tet whose circumradius is more than radius_edge times its
// shortest edge, and at least least_radius, gets its circumcentre inserted where that is possible; also those
// that come into being, worst first, until hardly any is left or the mesh has `most_tets`. Ends because no
// vertex comes nearer to another one than the shortest edge of the tet it mends, and radius_edge > 1. Stops
// early when `context` says so. Returns the number of vertices inserted.
std::int64_t refine(LocalOperations& work, double radius_edge, double least_radius, std::int64_t most_tets,
                    const RunContext& context);

}  // namespace overtet
