// Tet meshes of large complexes: Delaunay tets of the points first, which already have most facets of a
// well-shaped surface among their faces; only around the other facets are they replaced, a few at a time.
// Where too many are missing, the tets show where the complex can be cut, and TetGen meshes the parts
// (domain_parts.h).
//
// TetGen's own way, which this stands for, works through all segments and facets one by one, whether they are
// missing or not, on one thread.
#pragma once

#include "kernels/delaunay/delaunay.h"
#include "src/cdt/domain_parts.h"
#include "src/cdt/tetgen.h"

namespace overtet {

struct DelaunayFirstOptions {
  // If more than this share of the facets is missing, TetGen does all of them, in parts. Where it must not,
  // cavities are filled up to another share, and beyond that nothing is done.
  bool in_parts = true;
  double most_missing = 0.2, most_missing_without_parts = 0.5;
  // If TetGen would get more facets and walls of cavities than this share of all facets, it may as well do
  // all of them.
  double most_left = 0.5;
  Index free_points = 0;    // the last so many points lie on no facet and may be left out; not in parts
  PartsOptions parts = {};  // patience and splits count for what TetGen is left with, too
};

// What tetrahedralize() with keep_facets and without quality promises, for the same input. The same result on
// any number of threads. begun: has the complex's first points, then the free ones.
// Errors: those of tetrahedralize(); unsolved also where this does not pay.
Result<TetgenResult> tetrahedralize_delaunay_first(const Plc& plc, const RunContext& context,
                                                   const DelaunayFirstOptions& options = {},
                                                   DelaunayBuilder begun = {});

}  // namespace overtet
