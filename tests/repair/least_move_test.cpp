#include "src/repair/least_move.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "src/exact/winding.h"
#include "src/pipeline/pipeline.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

// A ball that faces inwards, half of it outside one that faces outwards: a cap of negative winding.
Surface with_cap() {
  return test::joined(test::sphere(3), test::flipped(test::sphere(3, 0.5, Eigen::Vector3d(1, 0.01, 0.02))));
}

std::optional<LeastMove> of(const Surface& s) {
  const Result<Diagnosis> d = diagnose(s, {}, {});
  return d ? least_move(s, d.value(), {}) : std::nullopt;
}

TEST(LeastMove, CapOfKnownThickness) {
  const auto least = of(with_cap());
  ASSERT_TRUE(least);
  EXPECT_LE(least->distance,
            0.255);  // the caps of smooth balls are half as thick, and the faces cut off some
  EXPECT_GE(least->distance, 0.23);
}

TEST(LeastMove, NoFaceIsNearer) {
  const Surface s = with_cap();
  const auto least = of(s);
  ASSERT_TRUE(least);
  double nearest = 1e300;
  const int n = 12;
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        const Eigen::RowVector3d p =
            (i * s.V.row(s.F(f, 0)) + j * s.V.row(s.F(f, 1)) + (n - i - j) * s.V.row(s.F(f, 2))) / n;
        nearest = std::min(nearest, (p - least->at.transpose()).norm());
      }
  EXPECT_GE(nearest, least->distance);
  EXPECT_LE(nearest, least->distance + 0.01);
}

TEST(LeastMove, SmallerMovesLeaveTheWindingNegative) {
  Surface s = with_cap();
  const auto least = of(s);
  ASSERT_TRUE(least);
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const VertexMatrix V = s.V;
  for (int i = 0; i < 20; ++i) {
    for (Index v = 0; v < V.rows(); ++v) {
      const Eigen::RowVector3d d(normal(random), normal(random), normal(random));
      s.V.row(v) = V.row(v) + 0.999 * least->distance * d.normalized();
    }
    const auto w = WindingNumber(s).at(least->at.data());
    ASSERT_TRUE(w);
    EXPECT_LT(*w, 0);
  }
}

TEST(LeastMove, NothingWhereNothingIsNegative) {
  EXPECT_FALSE(of(test::sphere()));
  EXPECT_FALSE(of(test::two_spheres()));
}

TEST(LeastMove, ARepairThatMayNotMoveSoFarSaysSoAtOnce) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  options.max_repair_move = 0.05;
  const PipelineResult r = run_pipeline(with_cap(), options, {});
  EXPECT_EQ(r.report.status, RunStatus::infeasible);
  EXPECT_NE(r.report.message.find("at least 6."), std::string::npos) << r.report.message;
}

}  // namespace
}  // namespace overtet
