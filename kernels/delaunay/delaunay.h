// The Delaunay tetrahedra of points, as plain arrays.
#pragma once

#include <array>
#include <functional>

#include "kernels/parallel/raw_vector.h"
#include "overtet/types.h"

namespace overtet {

// Tets with neighbours: next[t][k] is the tet beyond the face opposite to corner k, or -1.
struct TetArrays {
  RawVector<std::array<Index, 4>> tet, next;
};

// The faces of a positive tet, by the corner opposite to each, counter-clockwise seen from outside.
inline constexpr int kTetFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

// points: n rows of three finite doubles, no two alike. The tets fill the convex hull, all of them exactly
// positive; decisions are exact. Empty when all points lie in a plane, or when stop() has said so (it is
// asked every few thousand points).
//
// Serial but for the last step; O(n log n) for points spread over a surface. Points on common spheres are
// told apart by their coordinates (symbolic perturbation), so the answer depends on the points and their
// order only.
TetArrays delaunay(const double* points, Index n, const std::function<bool()>& stop);

}  // namespace overtet
