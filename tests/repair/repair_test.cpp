#include "src/repair/repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "src/pipeline/pipeline.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

Verdict verdict_of(const Surface& s) {
  const auto d = diagnose(s, {}, {});
  return d.ok() ? d.value().verdict : Verdict::bad_input;
}

double diagonal(const Surface& s) { return (s.V.colwise().maxCoeff() - s.V.colwise().minCoeff()).norm(); }

// What every repair promises; returns the result for more.
RepairResult repaired(const Surface& s, const RepairOptions& options = {}) {
  auto r = repair(s, options, {});
  EXPECT_TRUE(r.ok()) << (r.ok() ? "" : r.error().message);
  if (!r.ok()) return {};
  const RepairResult& x = r.value();
  EXPECT_EQ(x.surface.F, s.F);
  double largest = 0;
  for (Index v = 0; v < s.V.rows(); ++v) {
    const bool moved = std::binary_search(x.moved.begin(), x.moved.end(), v);
    EXPECT_EQ(moved, x.surface.V.row(v) != s.V.row(v)) << "vertex " << v;
    largest = std::max(largest, (x.surface.V.row(v) - s.V.row(v)).norm() / diagonal(s));
  }
  EXPECT_LE(largest, options.max_relative_move);
  EXPECT_DOUBLE_EQ(largest, x.max_relative);
  const Verdict verdict = verdict_of(x.surface);
  EXPECT_TRUE(verdict == Verdict::feasible || verdict == Verdict::embedded) << verdict_name(verdict);
  return std::move(r).value();
}

// A sphere of which one vertex is pulled through the far side.
Surface speck(double depth) {
  Surface s = test::sphere(3);
  Index top = 0, bottom = 0;
  s.V.col(2).maxCoeff(&top);
  s.V.col(2).minCoeff(&bottom);
  s.V.row(top) = s.V.row(bottom) + Eigen::RowVector3d(0.011, 0.017, -depth);
  return s;
}

// A torus with a vertex pushed across a neighbouring edge, so that its ring folds over.
Surface folded(double past) {
  Surface s = test::sphere(3);
  const Index v = 200;
  Eigen::RowVector3d next = Eigen::RowVector3d::Zero();
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if (s.F(f, k) == v) next = s.V.row(s.F(f, (k + 1) % 3));
  s.V.row(v) += (1 + past) * (next - s.V.row(v)) * 1.7;
  s.V.row(v) *= 0.97;
  return s;
}

TEST(Repair, LeavesWhatNeedsNoneAlone) {
  for (const Surface& s : {test::sphere(2), test::curled_worm(), test::two_spheres()}) {
    const RepairResult r = repaired(s);
    EXPECT_TRUE(r.moved.empty());
    EXPECT_EQ(r.termination, "nothing to repair");
  }
}

TEST(Repair, SpecksOfAllSizesGoAway) {
  for (const double depth : {1e-1, 1e-3, 1e-6, 1e-12}) {
    SCOPED_TRACE(depth);
    const Surface s = speck(depth);
    if (verdict_of(s) != Verdict::infeasible) ADD_FAILURE() << "the generated speck is none";
    RepairOptions options;
    options.max_relative_move = 0.7;  // the vertex went through the whole sphere
    const RepairResult r = repaired(s, options);
    EXPECT_LE(r.moved.size(), 30u);
  }
}

TEST(Repair, FoldedRingsOpen) {
  for (const double past : {0.0, 0.2, 0.5}) {
    SCOPED_TRACE(past);
    const Surface s = folded(past);
    const Verdict verdict = verdict_of(s);
    const RepairResult r = repaired(s);
    if (verdict == Verdict::infeasible || verdict == Verdict::obstructed) {
      EXPECT_FALSE(r.moved.empty());
    }
  }
}

TEST(Repair, FacesWithoutAreaGetOne) {
  Surface s = test::box(4);
  // A corner of a face onto the middle of the opposite edge.
  const auto f = s.F.row(40);
  s.V.row(f[0]) = (s.V.row(f[1]) + s.V.row(f[2])) / 2;
  ASSERT_EQ(verdict_of(s), Verdict::bad_input);
  const RepairResult r = repaired(s);
  EXPECT_FALSE(r.moved.empty());
  EXPECT_LE(r.moved.size(), 3u);
}

TEST(Repair, SaysWhenTheAllowedMoveIsTooSmall) {
  RepairOptions options;
  options.max_relative_move = 1e-4;
  const auto r = repair(test::saucer(2), options, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::infeasible);
}

TEST(Repair, RefusesWhatIsNoClosedSurface) {
  Surface s = test::sphere(1);
  s.F.conservativeResize(s.F.rows() - 1, 3);
  const auto r = repair(s, {}, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::bad_input);
}

TEST(Repair, AComponentInsideOutIsNotRepaired) {
  const auto r = repair(test::flipped(test::sphere(1)), {}, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::infeasible);
}

TEST(Repair, SameBytesOnAnyNumberOfThreads) {
  RepairOptions options;
  options.max_relative_move = 0.7;
  RunContext one, four;
  one.threads = 1;
  four.threads = 4;
  const Surface s = speck(1e-2);
  const auto a = repair(s, options, one), b = repair(s, options, four);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.value().surface.V, b.value().surface.V);
}

TEST(Repair, RepairedSurfacesAreMeshedExactly) {
  PipelineOptions options;
  options.on_infeasible = OnInfeasible::repair;
  for (const double depth : {0.3, 0.8}) {
    SCOPED_TRACE(depth);
    const Surface s = test::saucer(2, depth);
    const PipelineResult r = run_pipeline(s, options, {});
    if (verdict_of(s) != Verdict::infeasible) {
      EXPECT_EQ(r.report.status, RunStatus::exact);
      continue;
    }
    if (!r.ok()) {  // deeper than vertices may move: then nothing is claimed
      EXPECT_EQ(r.exit_code(), 5);
      EXPECT_TRUE(r.report.witness.has_value());
      continue;
    }
    EXPECT_EQ(r.report.status, RunStatus::repaired);
    EXPECT_GT(r.report.moved_vertices, 0);
    EXPECT_LE(r.report.max_relative_move, 0.06);
    Index same = 0;
    for (Index v = 0; v < s.V.rows(); ++v) same += r.mesh.V.row(v) == s.V.row(v);
    EXPECT_EQ(same, s.V.rows() - r.report.moved_vertices);
  }
}

TEST(Repair, AFoldInAPipelineRunIsRepaired) {
  PipelineOptions options;
  options.on_infeasible = OnInfeasible::repair;
  const Surface s = folded(0.2);
  const PipelineResult r = run_pipeline(s, options, {});
  EXPECT_TRUE(r.ok()) << r.error.message;
}

}  // namespace
}  // namespace overtet
