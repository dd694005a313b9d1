#include "kernels/core/tet_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "kernels/predicates/predicates.h"

namespace overtet {
namespace {

constexpr double kCorner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};  // positive

int side(const int* face, int k) {
  return orient3d(kCorner[face[0]], kCorner[face[1]], kCorner[face[2]], kCorner[k]);
}

TEST(TetTables, TheTetIsPositive) { ASSERT_EQ(orient3d(kCorner[0], kCorner[1], kCorner[2], kCorner[3]), 1); }

TEST(TetTables, AFaceHasTheOtherThreeCornersAndLooksOutOrIn) {
  for (int k = 0; k < 4; ++k) {
    for (const int* face : {kTetFace[k], kTetInnerFace[k]})
      EXPECT_EQ(std::set<int>({face[0], face[1], face[2], k}).size(), 4u) << k;
    EXPECT_EQ(side(kTetFace[k], k), -1) << k;
    EXPECT_EQ(side(kTetInnerFace[k], k), 1) << k;
  }
}

TEST(TetTables, EdgesAreAllPairsInOrderOppositeOnesAtOppositeEnds) {
  for (int e = 0; e < 6; ++e) {
    EXPECT_LT(kTetEdge[e][0], kTetEdge[e][1]);
    if (e > 0) {
      EXPECT_TRUE(
          std::lexicographical_compare(kTetEdge[e - 1], kTetEdge[e - 1] + 2, kTetEdge[e], kTetEdge[e] + 2));
    }
    const auto &a = kTetEdge[e], &b = kTetEdge[5 - e];
    EXPECT_EQ(std::set<int>({a[0], a[1], b[0], b[1]}).size(), 4u) << e;
  }
}

TEST(TetTables, FacesOfATetAreItsCorners) {
  const std::array<int, 4> tet{10, 11, 12, 13};
  EXPECT_EQ(tet_face(tet, 1), (std::array<int, 3>{10, 13, 12}));
  EXPECT_EQ(tet_inner_face(tet, 1), (std::array<int, 3>{10, 12, 13}));
  TetMatrix T(2, 4);
  T << 0, 1, 2, 3, 4, 5, 6, 7;
  EXPECT_EQ(tet_face(T.row(1), 0), (std::array<Index, 3>{5, 6, 7}));
}

}  // namespace
}  // namespace overtet
