#include "kernels/near_points/near_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "kernels/parallel/parallel.h"

namespace overtet {
namespace {

// Some in a cloud, some on a plane, some in one place; all times `scale`.
VertexMatrix some_points(Index n, unsigned seed, double scale) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  VertexMatrix V(n, 3);
  for (Index i = 0; i < n; ++i) {
    V.row(i) = scale * Eigen::RowVector3d(uniform(random), uniform(random), uniform(random));
    if (i % 3 == 1) V(i, 0) = 0;
    if (i % 7 == 2) V.row(i) = V.row(static_cast<Index>(random() % static_cast<unsigned>(i)));
  }
  return V;
}

TEST(NearPoints, AsByLookingAtAllPairs) {
  for (const double scale : {1.0, 1e-200, 1e200})
    for (const Index n : {1, 2, 9, 700}) {
      const VertexMatrix V = some_points(n, static_cast<unsigned>(n), scale);
      const NearPoints points(V);
      std::int64_t coincident = 0;
      double least = HUGE_VAL;
      for (Index i = 0; i < n; ++i) {
        bool twin = false;
        std::vector<Index> near, found;
        for (Index j = 0; j < n; ++j) {
          const double d = ((V.row(i) - V.row(j)) / scale).norm();
          if (d <= 0.2) near.push_back(j);
          if (j == i) continue;
          twin = twin || V.row(i) == V.row(j);
          least = std::min(least, d);
        }
        coincident += twin;
        points.within(V.row(i), 0.2 * scale, found);
        EXPECT_EQ(near, found);
        points.within(V.row(i), 0, found);
        EXPECT_EQ(twin, found.size() > 1);
      }
      const NearPoints::Closest closest = points.closest();
      EXPECT_EQ(coincident, closest.coincident);
      if (n == 1) {
        EXPECT_EQ(-1, closest.a);
        continue;
      }
      EXPECT_NEAR(least, closest.distance / scale, 1e-12 * least);
      EXPECT_LT(closest.a, closest.b);
      EXPECT_NEAR(least, ((V.row(closest.a) - V.row(closest.b)) / scale).norm(), 1e-12 * least);
    }
}

TEST(NearPoints, ClosestTwoThatDoNotCoincide) {
  VertexMatrix V(3, 3);
  V << 0, 0, 0, 1e-170, 0, 0, 1, 1, 1;  // the square of the distance is no number any more
  const NearPoints::Closest closest = NearPoints(V).closest();
  EXPECT_EQ(0, closest.coincident);
  EXPECT_GT(closest.distance, 0);
  EXPECT_EQ(0, closest.a);
  EXPECT_EQ(1, closest.b);
}

TEST(NearPoints, TheSameOnAnyNumberOfThreads) {
  const VertexMatrix V = some_points(30000, 5, 1);
  std::vector<NearPoints::Closest> all;
  for (const int threads : {1, 3}) {
    const ScopedThreads scope(threads);
    all.push_back(NearPoints(V).closest());
  }
  EXPECT_EQ(all[0].a, all[1].a);
  EXPECT_EQ(all[0].b, all[1].b);
  EXPECT_EQ(all[0].coincident, all[1].coincident);
  EXPECT_GT(all[0].coincident, 1000);
}

}  // namespace
}  // namespace overtet
