// The arrangement of a surface with itself: every face is cut along the curves in which other faces meet
// it, so that what comes out is a complex whose triangles meet in shared vertices and edges only.
//
// Cuts are computed in exact rational arithmetic; the points they add are then rounded to doubles. Where that
// makes pieces cross or collapse, they are cut again, with the added points on a grid that grows from round
// to round (iterated snap rounding), until an exact test finds the complex free of intersections. Input
// positions never move. Added points need not: they are taken off the boundary later (boundary_recovery.h),
// so a face's pieces may leave its plane by the rounding.
#pragma once

#include <utility>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// An input face that runs along a triangle of the arrangement.
struct ArrangementSheet {
  Index face = 0;
  int sign = 1;  // +1: the face has the triangle's orientation; -1: the opposite one
};

struct Arrangement {
  VertexMatrix
      V;  // #X x 3; first the input's distinct positions (with a tolerance: one of several), in order
  TriangleMatrix F;                      // #G x 3; no two alike
  std::vector<Index> sheet_begin;        // #G + 1; sheets of triangle g: [sheet_begin[g], sheet_begin[g + 1])
  std::vector<ArrangementSheet> sheets;  // more than one only where faces coincide
  std::vector<Index> vertex_of_input;    // #V; the arrangement's vertex at (or near) each input vertex
  Index input_positions = 0;             // the first rows of V that are input positions
  Index cut_faces = 0;                   // input faces that were cut
  int rounds = 1;                        // of cutting and rounding
  bool tolerant = false;                 // input positions closer than the tolerance have become one
};

struct ArrangeOptions {
  // Relative to the largest coordinate, a power of two. 0: cuts are exact. Otherwise vertices and edges of
  // the input closer than that count as touching (tolerant_cutter.h): for surfaces that nearly coincide.
  double tolerance = 0;
};

// pairs: all intersecting pairs of faces (src/surface/), i < j.
// pre: every face of the surface has a positive area, decided exactly.
Result<Arrangement> arrange(const Surface& surface, const std::vector<std::pair<Index, Index>>& pairs,
                            const ArrangeOptions& options, const RunContext& context);
inline Result<Arrangement> arrange(const Surface& surface, const std::vector<std::pair<Index, Index>>& pairs,
                                   const RunContext& context) {
  return arrange(surface, pairs, {}, context);
}

}  // namespace overtet
