// Delaunay refinement of the inside: circumcentres of badly shaped tets become vertices, so that what comes
// after has vertices to work with. Shewchuk, "Tetrahedral mesh generation by Delaunay refinement" (1998); the
// boundary is never split: a centre that encroaches upon it is left out.
#pragma once

#include <cstdint>
#include <span>

#include "overtet/run_context.h"
#include "src/mesh/local_operations.h"

namespace overtet {

// Every tet whose circumradius is more than radius_edge times its shortest edge
// gets its circumcentre inserted where that is possible; also those that come into being, worst first, until
// hardly any is left or the mesh has `most_tets`. Tets at a vertex for which `loose` holds (others are beyond
// its end) are left alone: its short edges are to be collapsed, not graded to. Ends because no vertex comes
// nearer to another one than the shortest edge of the tet it mends, and radius_edge > 1. Stops early when
// `context` says so. Returns the number of vertices inserted.
std::int64_t refine(LocalOperations& work, double radius_edge, std::span<const char> loose,
                    std::int64_t most_tets, const RunContext& context);

// Contracts edges from loose vertices with tets of a smallest dihedral sine below `bad` to where all tets get
// better, the shortest edge first. Returns how many.
std::int64_t contract_loose(LocalOperations& work, std::span<const char> loose, double bad,
                            const RunContext& context);

}  // namespace overtet
