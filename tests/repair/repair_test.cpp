#include "src/repair/repair.h"
#include "tests/repair/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "src/pipeline/pipeline.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using test::verdict_of;

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

// A sphere one side of which was pushed in until it sticks out of the other one, inside out.
Surface poked(double width) {
  Surface s = test::sphere(2);
  const double depth = 1.15 * (s.V.col(2).maxCoeff() - s.V.col(2).minCoeff());
  Index top = 0;
  s.V.col(2).maxCoeff(&top);
  const Eigen::RowVector3d p = s.V.row(top);
  for (Index v = 0; v < s.V.rows(); ++v)
    s.V(v, 2) -= depth * std::exp(-(s.V.row(v) - p).squaredNorm() / (width * width));
  return s;
}

// A thin capsule whose end was carried off and back, so that what joins the two is inside out.
Surface inside_out_limb(double sideways, double back) {
  Surface s = test::capsule(6, 0.2, 20);
  Eigen::Index axis = 0;
  (s.V.colwise().maxCoeff() - s.V.colwise().minCoeff()).maxCoeff(&axis);
  const double high = s.V.col(axis).maxCoeff(), low = s.V.col(axis).minCoeff();
  for (Index v = 0; v < s.V.rows(); ++v)
    if (s.V(v, axis) > high - 0.2 * (high - low)) {
      s.V(v, axis) -= back;
      s.V(v, (axis + 1) % 3) += sideways;
    }
  return s;
}

// A cylinder bent about an axis that runs through it, so that many faces meet along that axis, a little
// crumpled.
Surface crumpled_elbow(double degrees) {
  constexpr int kAround = 20, kFan = 16;
  constexpr double kAxis = 0.53;
  const double angle = degrees * M_PI / 180;
  const auto bent = [&](double x, double y, double z) {
    const double part = std::clamp(x, 0.0, 1.0), rest = x - part, a = angle * part, q = y - kAxis;
    return Eigen::RowVector3d(rest > 0 ? rest * std::cos(a) - std::sin(a) * q : rest - std::sin(a) * q,
                              kAxis + std::cos(a) * q + (rest > 0 ? rest * std::sin(a) : 0), z);
  };
  std::vector<double> at;
  for (int i = 0; i < 8; ++i) at.push_back(-4 + 0.5 * i);
  for (int i = 0; i <= kFan; ++i) at.push_back(static_cast<double>(i) / kFan);
  for (int i = 1; i <= 8; ++i) at.push_back(1 + 0.5 * i);
  Surface s;
  const auto n = static_cast<Index>(at.size());
  s.V.resize(n * kAround + 2, 3);
  s.F.resize(2 * n * kAround, 3);
  for (Index i = 0; i < n; ++i)
    for (int k = 0; k < kAround; ++k) {
      const double t = 2 * M_PI * k / kAround;
      s.V.row(i * kAround + k) = bent(at[i], std::cos(t), std::sin(t));
    }
  s.V.row(n * kAround) = bent(-4.5, 0, 0);
  s.V.row(n * kAround + 1) = bent(5.5, 0, 0);
  Index f = 0;
  for (int k = 0; k < kAround; ++k) {
    const int l = (k + 1) % kAround;
    for (Index i = 0; i + 1 < n; ++i) {
      const Index a = i * kAround + k, b = i * kAround + l;
      s.F.row(f++) << a, b + kAround, b;
      s.F.row(f++) << a, a + kAround, b + kAround;
    }
    s.F.row(f++) << n * kAround, k, l;
    s.F.row(f++) << n * kAround + 1, (n - 1) * kAround + l, (n - 1) * kAround + k;
  }
  for (Index v = 0; v < s.V.rows(); ++v)
    for (int k = 0; k < 3; ++k) s.V(v, k) += 2e-3 * std::sin(12.9898 * v + 78.233 * k);
  return test::signed_volume(s) > 0 ? s : test::flipped(s);
}

TEST(Repair, LimbsThatAreInsideOutAreTurned) {
  const Surface s = inside_out_limb(2.5, 3.0);
  ASSERT_TRUE(test::is_closed_oriented(s));
  ASSERT_EQ(verdict_of(s), Verdict::infeasible);
  const RepairResult r = repaired(s);
  EXPECT_GE(r.turned_parts, 1);
}

TEST(Repair, CreasesAreSmoothed) {
  int infeasible = 0;
  for (const double degrees : {70.0, 120.0}) {
    SCOPED_TRACE(degrees);
    const Surface s = crumpled_elbow(degrees);
    ASSERT_TRUE(test::is_closed_oriented(s));
    infeasible += verdict_of(s) == Verdict::infeasible;
    repaired(s);
  }
  EXPECT_GT(infeasible, 0);
}

TEST(Repair, NearlyDegenerateFacesToo) {
  for (const double rest : {0.0, 1e-17, 1e-15}) {
    SCOPED_TRACE(rest);
    Surface needle = test::box(4), point = test::sphere(2);
    const auto f = needle.F.row(40).eval();
    needle.V.row(f[0]) =
        (1 - rest) * (needle.V.row(f[1]) + needle.V.row(f[2])) / 2 + rest * needle.V.row(f[0]);
    const auto g = point.F.row(40).eval();
    point.V.row(g[0]) =
        (1 - rest) * point.V.row(g[1]) + rest * point.V.row(g[0]);  // two vertices in one place
    for (const Surface& s : {needle, point}) {
      MeshingOptions options;
      options.on_infeasible = OnInfeasible::repair;
      const PipelineResult r = run_pipeline(s, options, {});
      EXPECT_TRUE(r.ok()) << r.error.message;
      EXPECT_LE(r.report.moved_vertices, 4);
      EXPECT_EQ(r.report.moved_ids.size(), static_cast<std::size_t>(r.report.moved_vertices));
      EXPECT_LE(r.report.mean_relative_move, r.report.max_relative_move);
    }
  }
}

TEST(Repair, MovesGentlyWhereThatSuffices) {
  const Surface s = speck(1e-3);
  RepairOptions options;
  options.max_relative_move = 0.7;
  options.gentle_relative_move = 0.7;
  const RepairResult r = repaired(s, options);
  EXPECT_LE(r.max_relative, 0.7);
  const RepairResult fold = repaired(folded(0.2));
  double edges = 0;
  const Surface f = folded(0.2);
  for (Index i = 0; i < f.F.rows(); ++i) edges += (f.V.row(f.F(i, 0)) - f.V.row(f.F(i, 1))).norm();
  EXPECT_LE(fold.max_relative, std::max(0.01, edges / static_cast<double>(f.F.rows()) / diagonal(f)));
}

TEST(Repair, GoesOnFromAnEarlierOne) {
  const Surface s = speck(1e-2);
  RepairOptions options;
  options.max_relative_move = 0.7;
  const RepairResult first = repaired(s, options);
  ASSERT_TRUE(first.memory);
  options.earlier = first.memory;
  const RepairResult second = repaired(s, options);
  EXPECT_NE(first.surface.V, second.surface.V);
  options.place = first.surface.V.row(first.moved.front()).transpose();
  const RepairResult third = repaired(s, options);
  EXPECT_NE(first.surface.V, third.surface.V);
  EXPECT_FALSE(repair(test::sphere(1), options, {}).ok());
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
    if (verdict == Verdict::infeasible) {
      EXPECT_FALSE(r.moved.empty());
    }
  }
}

TEST(Repair, FacesWithoutAreaGetOne) {
  Surface s = test::box(4);
  // A corner of a face onto the middle of the opposite edge.
  const auto f = s.F.row(40);
  s.V.row(f[0]) = (s.V.row(f[1]) + s.V.row(f[2])) / 2;
  ASSERT_EQ(verdict_of(s), Verdict::infeasible);
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
  MeshingOptions options;
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
      EXPECT_TRUE(r.report.certificate.has_value());
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

// Deeper than any vertex may move on its way: out, and back as far as it goes.
TEST(Repair, TheMeshIsPulledBack) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  options.improve_degrees = 0;
  options.max_repair_move = 0.1;
  for (const Surface& s : {poked(0.3), poked(0.5)}) {
    ASSERT_TRUE(test::is_closed_oriented(s));
    const PipelineResult r = run_pipeline(s, options, {});
    ASSERT_TRUE(r.ok()) << r.error.message;
    if (verdict_of(s) == Verdict::feasible) continue;
    EXPECT_EQ(r.report.status, RunStatus::repaired);
    EXPECT_LE(r.report.max_relative_move, options.max_repair_move);
    Index moved = 0;
    double largest = 0;
    for (Index v = 0; v < s.V.rows(); ++v) {
      moved += r.mesh.V.row(v) != s.V.row(v);
      largest = std::max(largest, (r.mesh.V.row(v) - s.V.row(v)).norm() / diagonal(s));
    }
    EXPECT_EQ(moved, r.report.moved_vertices);
    EXPECT_DOUBLE_EQ(largest, r.report.max_relative_move);
    // Never more than what smoothing alone comes to.
    const auto smoothed = repair(s, {}, {});
    if (smoothed.ok()) {
      EXPECT_LE(moved, static_cast<Index>(smoothed.value().moved.size()));
    }
  }
}

TEST(Repair, SaysHowFarVerticesWouldHaveToMove) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  options.improve_degrees = 0;
  options.max_repair_move = 1e-3;
  const PipelineResult r = run_pipeline(poked(0.5), options, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.exit_code(), 5);
  EXPECT_NE(r.error.message.find("allow that much"), std::string::npos) << r.error.message;
  EXPECT_TRUE(r.report.certificate.has_value());
}

TEST(Repair, AFoldInAPipelineRunIsRepaired) {
  MeshingOptions options;
  options.on_infeasible = OnInfeasible::repair;
  const Surface s = folded(0.2);
  const PipelineResult r = run_pipeline(s, options, {});
  EXPECT_TRUE(r.ok()) << r.error.message;
}

}  // namespace
}  // namespace overtet
