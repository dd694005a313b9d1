// The faces around an edge of 4, 6, ... faces, paired so that each pair is an edge of its own.
#pragma once

#include <array>
#include <vector>

#include "overtet/types.h"
#include "src/cleanup/orienting.h"
#include "src/cleanup/raw_edges.h"

namespace overtet {

// What the faces of a pair have between them, going around the edge from the first to the second.
enum class Sector { solid, gap };

// One half-edge of each pair runs the other way than the other one, with the faces turned as `oriented` says.
// Empty where the faces cannot be told apart in pairs.
//
// The faces of a shell that has as many running one way as the other are paired with each other: what hangs
// together elsewhere does so here. The rest is paired around the edge. Going around it, a face has the solid
// either before or behind it, as brackets open and close; pairs are the brackets that match, in the exact
// angular order of the faces. So no pair crosses another one, and solids that only touch come apart (or, with
// Sector::gap, gaps do: where a solid is pinched off at the edge it stays in one piece). Of faces that lie on
// each other those that close come first.
std::vector<std::array<Index, 2>> pair_around(const VertexMatrix& V, const TriangleMatrix& F,
                                              const RawEdges& edges, const Oriented& oriented,
                                              const EdgeGroup& edge, Sector sector);

}  // namespace overtet
