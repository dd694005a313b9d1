// The exact arrangement of a surface with itself: every face is cut along the curves in which other
// faces meet it, so that what comes out is a complex whose triangles meet in shared vertices and edges
// only. All cuts are computed in exact rational arithmetic; points that are no input vertices are then
// rounded to doubles. Rounding can make triangles cross again where features are smaller than the
// rounding; the caller checks that with the exact intersection test before building on the result.
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
  VertexMatrix V;  // #X x 3; first the input's distinct positions, in order of appearance
  TriangleMatrix F;  // #G x 3; no two alike
  std::vector<Index> sheet_begin;  // #G + 1; sheets of triangle g: [sheet_begin[g], sheet_begin[g + 1])
  std::vector<ArrangementSheet> sheets;  // more than one only where faces coincide
  std::vector<Index> vertex_of_input;    // #V; the arrangement's vertex at each input vertex
  Index input_positions = 0;             // the first rows of V that are input positions
  Index cut_faces = 0;                   // input faces that were cut
};

// pairs: all intersecting pairs of faces (src/surface/), i < j.
// pre: every face of the surface has a positive area, decided exactly.
Result<Arrangement> arrange(const Surface& surface, const std::vector<std::pair<Index, Index>>& pairs,
                            const RunContext& context);

}  // namespace overtet
