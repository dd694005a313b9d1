// Sheets: how many times the solid covers each cell of the arrangement, and how the copies are glued.
//
// The surface cuts space into cells of constant winding number w. A solid whose boundary is the
// surface covers a cell exactly w times (positive tets only add winding), so the abstract solid is
// made of w copies ("sheets") of every cell. Across a triangle of the arrangement with one surface
// face on it, the w copies outside continue into w of the w + 1 copies inside; the copy left over
// ends there: that is where the face is boundary. So a solid is a partial bijection ("gluing") of copies
// per triangle, such that around every edge
//   - every copy that is not cut by the surface closes after exactly one turn (no branch lines), and
//   - the copy that starts at one face of a surface edge ends at the other face of that edge, after k
//     full turns more than the dihedral angle seen in space: k = 0, except at wound edges, where
//     hinges force k > 0 (see src/covering/wound_edges.h).
// Gluings are constant on the regions between intersection curves, and relabelling the copies of a cell
// changes nothing, so what remains is a small exact constraint problem. With the wound edges given
// it is solved by backtracking (sheet_search.h); where that finds nothing, with others, as a formula
// (gluing_formula.h).
//
// Source: the cover view of immersions in the plane (Shor and Van Wyk 1992), and of solids (Li and Barbic
// 2018, "Immersion of self-intersecting solids and surfaces"), who exclude hinges.
#pragma once

#include <span>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/arrangement/arrangement.h"
#include "src/cdt/tetgen.h"
#include "src/covering/wound_edges.h"

namespace overtet {

// A tet mesh triangle that lies on the arrangement. Its front is the side that the normal of its
// arrangement triangle points to.
struct Facet {
  Index triangle = -1;          // of the arrangement; -1: a cut through a cell with a handle, no sheet
  Index front = -1, back = -1;  // tets; -1: outside everything
  Index region = -1;
  bool flipped = false;  // the region's front is this facet's back
  Index slots = -1;      // where coincident faces make several sheets: begin in Sheets::slot_map
};

// A set of connected facets with one gluing.
struct Region {
  Index front_winding = 0, back_winding = 0;
  std::vector<int> signs;     // per slot (sheet): +1 where the sheet's inside is the back
  std::vector<int> back_of;   // per front copy: its back copy, or -1 - slot where it ends
  std::vector<int> front_of;  // per back copy: its front copy, or -1 - slot where it ends
};

struct Sheets {
  std::vector<Index> cell;                     // #T: the cell of each tet
  std::vector<Index> winding;                  // #cells, >= 0
  std::vector<std::array<Index, 4>> facet_on;  // #T: the facet on the face opposite to each corner, or -1
  std::vector<Facet> facets;
  std::vector<Region> regions;
  std::vector<Index> slot_map;    // region slot of each sheet of a facet with several
  Index cuts = 0;                 // faces inside cells that had to be cut to make them simply connected
  Index constraints = 0;          // distinct kinds of edges that had to be satisfied
  std::int64_t search_nodes = 0;  // steps of the search, and questions to the solver of formulas

  Index winding_of(Index tet) const { return tet < 0 ? 0 : winding[cell[tet]]; }

  // Where `copy` of one side of a facet goes: the copy on the other side (>= 0), or -1 - s where it
  // ends at the facet's sheet s.
  int across(Index facet, bool from_front, int copy) const;
};

// pre: tets meshes the arrangement (keep_facets), facet markers are arrangement triangle + 1.
// variant: 0, or the number of another solution to be tried, with other wound edges or other layers glued.
// Errors: unsolved when a cell's winding number is negative, or when there is no gluing, with the place where
// the search got farthest; ErrorReason::exhausted when all wound edges and all gluings have been tried.
Result<Sheets> assign_sheets(const Surface& surface, const Arrangement& arrangement, const TetgenResult& tets,
                             std::span<const WoundEdge> wound, int variant, const RunContext& context);

}  // namespace overtet
