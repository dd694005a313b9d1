// The plain data every stage reads and writes: row-major matrices of doubles and 32-bit indices.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace overtet {

using Index = std::int32_t;  // of a vertex, face or tet; products of counts use std::int64_t

using VertexMatrix = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;   // #V x 3
using TriangleMatrix = Eigen::Matrix<Index, Eigen::Dynamic, 3, Eigen::RowMajor>;  // #F x 3
using TetMatrix = Eigen::Matrix<Index, Eigen::Dynamic, 4, Eigen::RowMajor>;       // #T x 4

// A triangle surface. Faces are counter-clockwise seen from outside.
struct Surface {
  VertexMatrix V;    // #V x 3
  TriangleMatrix F;  // #F x 3
};

// A tetrahedral mesh. The first `surface_vertices` rows of V are the surface's, in its order.
// A tet (a, b, c, d) is positive when det(b - a, c - a, d - a) > 0.
struct TetMesh {
  VertexMatrix V;  // #V x 3
  TetMatrix T;     // #T x 4
  Index surface_vertices = 0;
};

}  // namespace overtet
