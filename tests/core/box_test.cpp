#include "kernels/core/box.h"

#include <gtest/gtest.h>

#include <cmath>

namespace overtet {
namespace {

TEST(Box, DiagonalOfPointsOfAnySize) {
  VertexMatrix V(3, 3);
  V << 1, 2, 3, 3, 5, 9, 2, 2, 4;
  EXPECT_EQ(diagonal_of(V), 7);
  for (const int exponent : {-1000, -540, 540, 1000})
    EXPECT_DOUBLE_EQ(diagonal_of(V.unaryExpr([&](double x) { return std::ldexp(x, exponent); })),
                     std::ldexp(7, exponent));
  EXPECT_EQ(diagonal_of(VertexMatrix(0, 3)), 0);
}

}  // namespace
}  // namespace overtet
