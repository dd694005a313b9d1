#include "src/pipeline/unit_box.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/models.h"

namespace overtet {
namespace {

TEST(UnitBox, ThereAndBackIsExact) {
  for (const int e : {-1000, -200, -3, 0, 1, 17, 200, 1000}) {
    VertexMatrix V = test::transformed(test::sphere(2), test::some_rotation(1), Eigen::Vector3d(1, 2, 3)).V *
                     std::ldexp(1, e);
    const VertexMatrix before = V;
    const Result<UnitBox> box = into_unit_box(V);
    ASSERT_TRUE(box.ok());
    EXPECT_TRUE(box.value().uniform());
    EXPECT_LT(V.cwiseAbs().maxCoeff(), 1);
    EXPECT_GE(V.cwiseAbs().maxCoeff(), 0.5);
    const VertexMatrix inside = V;
    out_of_unit_box(V, box.value());
    EXPECT_EQ(V, before);
    back_into_unit_box(V, box.value());
    EXPECT_EQ(V, inside);
  }
}

TEST(UnitBox, ThinModelsAreScaledByAxis) {
  VertexMatrix V = test::sphere(2).V;
  V.col(0) *= 1e8;
  V.col(2) *= 1e-6;
  const VertexMatrix before = V;
  const Result<UnitBox> box = into_unit_box(V);
  ASSERT_TRUE(box.ok());
  EXPECT_FALSE(box.value().uniform());
  for (int k = 0; k < 3; ++k) EXPECT_GE(V.col(k).cwiseAbs().maxCoeff(), 0.5);
  out_of_unit_box(V, box.value());
  EXPECT_EQ(V, before);
}

TEST(UnitBox, RefusesWhatCannotBeScaled) {
  const auto refused = [](VertexMatrix V) {
    const Result<UnitBox> box = into_unit_box(V);
    return !box.ok() && box.error().code == ErrorCode::unsolved;
  };
  const VertexMatrix V = test::sphere(1).V;
  EXPECT_TRUE(refused(V * 0));
  VertexMatrix flat = V;
  flat.col(1).setConstant(7);
  EXPECT_TRUE(refused(flat));
  VertexMatrix tiny = V * 0x1p100;
  tiny(0, 0) = 0x1.23456789abcdep-1000;
  EXPECT_TRUE(refused(tiny));
}

}  // namespace
}  // namespace overtet
