#include "src/volume_map/potential.h"

#include <gtest/gtest.h>

namespace overtet::volume_map_detail {
namespace {

TEST(Potential, DerivativesMatchFiniteDifferences) {
  for (const double reach : {0.0, 1e-3, 0.7, 20.0})
    for (const double share :
         {0.01, 0.3, 0.9, 1.0, 1.4, 2.5}) {  // of the reach; the last beyond the steepest pull
      SCOPED_TRACE(testing::Message() << "reach " << reach << ", share " << share);
      const double x = share * share * (reach > 0 ? reach * reach : 1), h = 1e-5 * x;
      const Potential at = potential(x, reach), before = potential(x - h, reach),
                      after = potential(x + h, reach);
      EXPECT_NEAR((after.value - before.value) / (2 * h), at.slope, 1e-7 * at.slope);
      EXPECT_NEAR((after.slope - before.slope) / (2 * h), at.bend, 1e-6 * at.bend + 1e-9 / x);
    }
}

TEST(Potential, GrowsFasterBeyondTheReachAndIsInProportionWithoutOne) {
  EXPECT_EQ(potential(4, 0).value, 4);
  EXPECT_EQ(potential(4, 0).slope, 1);
  EXPECT_NEAR(potential(0.01, 1).value, 0.01, 1e-12);
  EXPECT_GT(potential(1, 1).slope, 10);
  EXPECT_EQ(potential(9, 1).slope, potential(100, 1).slope);  // steepest
}

}  // namespace
}  // namespace overtet::volume_map_detail
