#include "kernels/core/triangles.h"

#include <gtest/gtest.h>

namespace overtet {
namespace {

using Triple = std::array<int, 3>;

TEST(Triangles, KeysForgetHowATriangleIsTurned) {
  for (const Triple& f : {Triple{4, 7, 9}, Triple{7, 9, 4}, Triple{9, 4, 7}}) {
    EXPECT_EQ(rotated(f), (Triple{4, 7, 9}));
    EXPECT_EQ(sorted(f), (Triple{4, 7, 9}));
    const Triple flipped{f[1], f[0], f[2]};
    EXPECT_EQ(rotated(flipped), (Triple{4, 9, 7}));
    EXPECT_EQ(sorted(flipped), (Triple{4, 7, 9}));
  }
}

}  // namespace
}  // namespace overtet
