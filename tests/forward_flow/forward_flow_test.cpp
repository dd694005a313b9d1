#include "src/forward_flow/forward_flow.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <atomic>
#include <limits>
#include <numeric>
#include <random>

#include "kernels/contact/contact.h"
#include "kernels/parallel/parallel.h"
#include "tests/support/flow_surfaces.h"

namespace overtet {
namespace {

using Pair = std::array<Index, 2>;

std::vector<Pair> pairs_of(const Surface& s) {
  ContactMesh mesh(s.V, s.F, std::vector<char>(s.V.rows(), 1));
  std::vector<Pair> pairs;
  for (const IndexPair& p : mesh.intersections(s.V)) pairs.push_back({p.a, p.b});
  return pairs;
}

// Its two ends pass through each other.
Surface crossing() { return test::bent_capsule(390, 1, 0.25, 60, 12); }

ForwardFlowResult flow(const Surface& s, const ForwardFlowOptions& options = {}) {
  auto result = forward_flow(s, pairs_of(s), options, RunContext());
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  if (!result.ok()) return {};
  const Status fine = check_postconditions(s, result.value());
  EXPECT_TRUE(fine.ok()) << (fine.ok() ? "" : fine.error().message);
  return std::move(result).value();
}

TEST(ForwardFlow, RegionalRemovesTheCrossingAndLeavesTheRest) {
  const Surface s = crossing();
  ASSERT_GT(pairs_of(s).size(), 20u);
  const ForwardFlowResult r = flow(s);
  EXPECT_EQ(r.termination, ForwardFlowResult::Termination::regional);
  EXPECT_GT(r.frozen_area, 0.2);
  EXPECT_LT(r.frozen_area, 1);
  ASSERT_FALSE(r.steps.empty());
  EXPECT_EQ(r.steps.back().pairs, 0);
  EXPECT_TRUE(r.steps.back().all_pairs);
  // The stored states lie between: none of the last attempt's is free of intersections (t* is the first).
  ContactMesh mesh(s.V, s.F, std::vector<char>(s.V.rows(), 1));
  for (std::size_t i = 0; i < r.states.size(); ++i) EXPECT_FALSE(mesh.intersections(r.state(s.V, i)).empty());
}

TEST(ForwardFlow, CleanInputComesBackUntouched) {
  const Surface s = test::bent_capsule(200);
  const ForwardFlowResult r = flow(s);
  EXPECT_EQ(r.termination, ForwardFlowResult::Termination::clean_input);
  EXPECT_EQ(r.V, s.V);
  EXPECT_TRUE(r.active_vertices.empty());
}

TEST(ForwardFlow, EveryWayOfFlowingEverythingWorks) {
  const Surface s = crossing();
  ForwardFlowOptions options = paper_forward_flow();
  EXPECT_EQ(flow(s, options).weights, FlowWeights::cotangent);
  for (FlowWeights weights : {FlowWeights::clamped, FlowWeights::uniform, FlowWeights::intrinsic_delaunay}) {
    options.global = {{weights, 1e-4, 200}};
    const ForwardFlowResult r = flow(s, options);
    EXPECT_EQ(r.weights, weights) << to_string(weights);
    EXPECT_EQ(r.termination, ForwardFlowResult::Termination::global);
    EXPECT_EQ(r.frozen_area, 0);
  }
}

TEST(ForwardFlow, SameBytesOnAnyNumberOfThreads) {
  const Surface s = crossing();
  VertexMatrix first;
  for (int threads : {1, 2, 3, 8}) {
    RunContext context;
    context.threads = threads;
    const auto r = forward_flow(s, pairs_of(s), {}, context);
    ASSERT_TRUE(r.ok());
    if (threads == 1) first = r.value().V;
    EXPECT_EQ(r.value().V, first) << threads << " threads";
  }
}

TEST(ForwardFlow, PowerOfTwoScaleChangesNothingElse) {
  Surface s = crossing();
  const ForwardFlowResult a = flow(s);
  s.V *= 1024;
  const ForwardFlowResult b = flow(s);
  EXPECT_EQ(b.V, a.V * 1024);
}

TEST(ForwardFlow, WorksAfterRigidMotionAndRenumbering) {
  const Surface s = crossing();
  const ForwardFlowResult plain = flow(s);
  Surface moved = s;
  moved.V =
      (s.V * Eigen::Quaterniond(0.2, 0.5, -0.1, 0.7).normalized().toRotationMatrix().transpose()).rowwise() +
      Eigen::RowVector3d(3, -2, 1);
  EXPECT_NEAR(flow(moved).frozen_area, plain.frozen_area, 0.1);

  const std::uint32_t seed = 5;
  RecordProperty("seed", static_cast<int>(seed));
  std::vector<Index> order(s.V.rows());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  Surface renumbered = s;
  for (Eigen::Index v = 0; v < s.V.rows(); ++v) renumbered.V.row(order[v]) = s.V.row(v);
  for (Eigen::Index i = 0; i < s.F.size(); ++i) renumbered.F.data()[i] = order[s.F.data()[i]];
  EXPECT_NEAR(flow(renumbered).frozen_area, plain.frozen_area, 0.1);
}

TEST(ForwardFlow, ErrorsAreValues) {
  const Surface s = crossing();
  const auto pairs = pairs_of(s);
  const auto code = [&](const Surface& surface, std::vector<Pair> list, const ForwardFlowOptions& options,
                        const RunContext& context) {
    const auto r = forward_flow(surface, list, options, context);
    return r.ok() ? ErrorCode::internal : r.error().code;
  };
  ForwardFlowOptions hopeless = paper_forward_flow();
  hopeless.global = {{FlowWeights::cotangent, 1e-9, 1}};
  EXPECT_EQ(code(s, pairs, hopeless, {}), ErrorCode::unsolved);
  ForwardFlowOptions wrong;
  wrong.radius = -1;
  EXPECT_EQ(code(s, pairs, wrong, {}), ErrorCode::usage);
  Surface bad = s;
  bad.V(7, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code(bad, pairs, {}, {}), ErrorCode::bad_input);
  bad = s;
  bad.F(3, 0) = static_cast<Index>(s.V.rows());
  EXPECT_EQ(code(bad, {}, {}, {}), ErrorCode::bad_input);
  bad = s;
  bad.V.setZero();
  EXPECT_EQ(code(bad, pairs, {}, {}), ErrorCode::bad_input);
  EXPECT_EQ(code(s, {{0, static_cast<Index>(s.F.rows())}}, {}, {}), ErrorCode::internal);

  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(code(s, pairs, {}, context), ErrorCode::interrupted);
  RunContext late;
  late.deadline = RunContext::Clock::now();
  EXPECT_EQ(code(s, pairs, {}, late), ErrorCode::limit);
}

TEST(ForwardFlow, LadderIsValid) {
  for (const auto& options : forward_flow_ladder()) EXPECT_TRUE(options.validate().ok());
  EXPECT_TRUE(paper_forward_flow().validate().ok());
}

}  // namespace
}  // namespace overtet
