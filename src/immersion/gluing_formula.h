// The gluings of all regions, and the turns of the edges that may be wound, as one propositional formula.
//
// Where the wound edges are known, gluings follow from their neighbours, and a search that goes from region
// to region (sheet_search.h) is at its end at once. Where edges may be wound, much follows only from many
// conditions together: how many turns end at a hinge, that a disc is there, which copies a chain of wound
// edges uses up. Clauses say all of it:
//
//   - a region: copies in front go on into copies behind, one to one; some end at a sheet.
//   - a fan: every copy next to it has one name, which crossing a facet does not change. Names are those of
//   the
//     copies of the sector with the fewest (so they close after one turn), or (pass, turn): the turn grows by
//     one where the pass began, and at the last one the pass is at its end.
//   - an edge that may be wound has one number of turns k, at all fans along it.
//   - a vertex: some copies of the sector with the fewest are closed layers (spheres around the vertex),
//   whose
//     names every sector has once; all others hang together with what ends at the vertex. Euler's formula
//     then says how many turns there are at its edges: sum k = chi - 2 layers - discs, where chi is what the
//     copies would have without turns. (A handle, and a sphere that has no name, would make up for each
//     other. Clauses that name the sphere are added where that happens.)
//
// No answer is a proof by itself; certificates are found, and checked, in other ways (src/certificates).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/immersion/sheet_puzzle.h"

namespace overtet {

struct FormulaAnswer {
  enum class Verdict { found, none, undecided } verdict = Verdict::undecided;
  std::vector<Gluing> gluings;  // per region, where found
  bool too_large = false;       // undecided, as any formula with more free edges would be
  std::optional<Error> stop;    // limit or interrupted: undecided for that reason
  std::int64_t solves = 0;      // of the formula and of what was added to it
};

// Gluings that satisfy all of the puzzle, with few wound edges: some that could be left alone while all
// others stay as they are have been, pierced ones first. variant: 0, or another number for what is as a rule
// another solution. Undecided: too large, too long, or stopped.
FormulaAnswer solve_as_formula(const std::vector<Region>& regions, const std::vector<Index>& winding,
                               const SheetPuzzle& puzzle, int variant, const RunContext& context);

}  // namespace overtet
