#include "kernels/core/indices.h"

#include <gtest/gtest.h>

#include "overtet/types.h"

namespace overtet {
namespace {

TEST(Indices, AreBelow) {
  TriangleMatrix F(2, 3);
  F << 0, 1, 2, 2, 1, 3;
  EXPECT_TRUE(all_below(F, 4));
  EXPECT_FALSE(all_below(F, 3));
  F(1, 0) = -1;
  EXPECT_FALSE(all_below(F, 4));
  EXPECT_TRUE(all_below(TriangleMatrix(0, 3), 0));
}

}  // namespace
}  // namespace overtet
