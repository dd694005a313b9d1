#include "src/repair/ray_hit.h"

#include <gtest/gtest.h>

#include <random>

namespace overtet {
namespace {

using Eigen::Vector3d;

// Against points that were put on a triangle.
TEST(RayHit, FindsThePlaceItWasShotAt) {
  const unsigned seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto point = [&] { return Vector3d(number(random), number(random), number(random)); };
  int inside = 0;
  for (int i = 0; i < 300; ++i) {
    const Vector3d a = point(), b = point(), c = point(), p = point();
    const double u = number(random), v = number(random), far = 0.5 + std::abs(number(random));
    if (std::min({std::abs(u), std::abs(v), std::abs(1 - u - v)}) < 1e-3)
      continue;  // the border rounds either way
    const Vector3d at = (1 - u - v) * a + u * b + v * c, d = (at - p) / far;
    const auto hit = ray_hit(p, d, a, b, c);
    ASSERT_EQ(hit.has_value(), u > 0 && v > 0 && u + v < 1);
    EXPECT_FALSE(ray_hit(p, -d, a, b, c));
    if (!hit) continue;
    ++inside;
    EXPECT_NEAR(hit->far, far, 1e-6);
    EXPECT_NEAR(hit->u, u, 1e-6);
    EXPECT_NEAR(hit->v, v, 1e-6);
  }
  EXPECT_GT(inside, 10);
  EXPECT_FALSE(ray_hit({0, 0, 1}, {1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}));  // along the plane
}

}  // namespace
}  // namespace overtet
