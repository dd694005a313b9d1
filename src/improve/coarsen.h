// Vertices out of the inside: edges from free vertices are contracted, the shortest first.
//
// Two uses. A mesh that is overfull (some surfaces of a few hundred faces leave 100,000 needles inside, at
// the curves in which they cross themselves) is thinned out before anything else: what follows then costs
// what a good mesh of that surface costs. And who asks for as few vertices as the target angle allows gets
// that at the end.
#pragma once

#include <cstdint>
#include <vector>

#include "overtet/run_context.h"
#include "src/mesh/local_operations.h"

namespace overtet {

// Contracts the shortest edge from v that can be: new tets are better than the worst that they replace, or
// than `enough` (a smallest dihedral sine). tets: of v. False: none can be. pre: v is free.
bool contract_shortest(LocalOperations& work, Index v, const std::vector<Index>& tets, double enough);

// Contracts edges from free vertices until hardly one is left that can go. New tets are better than the worst
// that they replace, or than `enough` (a smallest dihedral sine). Every vertex is tried again when something
// around it has changed. Returns how many have gone. Stops early when `context` says so.
// By all means: where none can be contracted the star is filled anew without the vertex, and what stays is
// smoothed, so that others can go.
enum class Removal { by_contraction, by_all_means };
std::int64_t coarsen(LocalOperations& work, double enough, Removal how, const RunContext& context);

}  // namespace overtet
