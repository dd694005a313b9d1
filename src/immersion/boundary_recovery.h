// Takes the points that the arrangement added off the boundary of the immersed solid, so that the boundary
// becomes the input surface: each point moves a little way inside, and the gap between the boundary
// triangles it had and the same region triangulated without it is filled with tets at the point.
//
// The move and the filling are one step: the moved point must see every face of its star and every new
// boundary triangle from the inside. That is a linear condition; its best solution (the largest ball
// inside all half-spaces) is searched, and every new tet is confirmed exactly positive. Moving a point
// along a segment with all tets positive at both ends keeps one turn around every edge (positivity is
// convex in one point), so nothing branches.
#pragma once

#include <array>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/mesh/tet_complex.h"

namespace overtet {

struct BoundaryPointsOptions {
  // A point on an edge that more than one turn winds around may take that along: it moves inside by itself,
  // and its edges become a branch line. Otherwise several points take its place, so that nothing branches.
  bool may_branch = false;
};

struct BoundaryPointsResult {
  Index removed = 0;
  Index refined_edges = 0;        // edges halved to make room
  std::vector<Index> left;        // vertices that could not be taken off the boundary
  double smallest_clearance = 0;  // least distance to a face of the star after a move, over all moves
};

// boundary, face: the boundary triangles of the complex, outward, and the input face each lies on.
BoundaryPointsResult clear_boundary_points(const Surface& surface, TetComplex& complex,
                                           const std::vector<std::array<Index, 3>>& boundary,
                                           const std::vector<Index>& face, const RunContext& context,
                                           const BoundaryPointsOptions& options = {});

// Moves the surface's vertices from where the complex has them, a hair away, to the surface's own positions,
// bit by bit, with every tet exactly positive; neighbours inside make room. Returns those that could not be
// moved.
std::vector<Index> bring_home(const Surface& surface, TetComplex& complex, const RunContext& context);

}  // namespace overtet
