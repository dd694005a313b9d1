#include "src/reverse_flow/reverse_flow.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>

#include "kernels/contact/contact.h"
#include "kernels/parallel/parallel.h"
#include "src/forward_flow/forward_flow.h"
#include "tests/support/flow_surfaces.h"

namespace overtet {
namespace {

std::vector<IndexPair> intersections(const Surface& s, const VertexMatrix& X) {
  return ContactMesh(X, s.F, std::vector<char>(X.rows(), 1)).intersections(X);
}

struct Case {
  Surface surface = test::bent_capsule(390, 1, 0.25, 50, 10);
  ForwardFlowResult forward;
  std::vector<VertexMatrix> states;
};

Case flowed(const ForwardFlowOptions& options = {}) {
  Case c;
  std::vector<std::array<Index, 2>> pairs;
  for (const IndexPair& p : intersections(c.surface, c.surface.V)) pairs.push_back({p.a, p.b});
  auto forward = forward_flow(c.surface, pairs, options, RunContext());
  EXPECT_TRUE(forward.ok());
  if (forward.ok()) c.forward = std::move(forward).value();
  for (std::size_t i = 0; i < c.forward.states.size(); ++i)
    c.states.push_back(c.forward.state(c.surface.V, i));
  return c;
}

ReverseFlowResult run(const Case& c, const ReverseFlowOptions& options, int threads = 0) {
  RunContext context;
  context.threads = threads;
  auto r = reverse_flow(c.surface, c.forward.V, c.states, c.forward.reverse_free, options, context);
  EXPECT_TRUE(r.ok()) << (r.ok() ? "" : r.error().message);
  if (!r.ok()) return {};
  const Status fine = check_postconditions(c.surface, c.forward.reverse_free, r.value());
  EXPECT_TRUE(fine.ok()) << (fine.ok() ? "" : fine.error().message);
  return std::move(r).value();
}

TEST(ReverseFlow, GivesTheShapeBack) {
  const Case c = flowed();
  const FlowQuality before = measure_quality(c.forward.V, c.surface.V, c.surface.F);
  const ReverseFlowResult r = run(c, {});
  EXPECT_LT(before.area_p01, 0.5) << "the forward flow did not even shrink it";
  EXPECT_GT(r.quality.area_p01, 0.8);
  EXPECT_LT(r.quality.area_p99, 1.25);
  EXPECT_GT(r.quality.edge_p01, 0.8);
  EXPECT_NEAR(r.quality.area_p50, 1, 0.05);
  EXPECT_FALSE(r.locked);
}

// Every way of doing it: each accepted state is clean, and so is the way from state to state.
TEST(ReverseFlow, NoStateAndNoStepCrosses) {
  ReverseFlowOptions direct, staged, paper = paper_reverse_flow(), inertia;
  staged.staged = true;
  inertia.inertia = true;
  direct.final_iterations = staged.final_iterations = paper.final_iterations = inertia.final_iterations = 30;
  staged.stage_iterations = paper.stage_iterations = 6;
  const Case c = flowed();
  for (ReverseFlowOptions options : {direct, staged, paper, inertia}) {
    VertexMatrix last = c.forward.V;
    int states = 0;
    options.on_state = [&](const VertexMatrix& X) {
      ASSERT_TRUE(X.allFinite());
      for (double t : {0.25, 0.5, 0.75, 1.0})
        ASSERT_TRUE(intersections(c.surface, (1 - t) * last + t * X).empty())
            << "state " << states << " at " << t;
      ++states;
      last = X;
    };
    const ReverseFlowResult r = run(c, options);
    EXPECT_EQ(states, r.iterations);
    EXPECT_EQ(r.steps.size(), static_cast<std::size_t>(r.iterations));
    EXPECT_GT(states, 0);
  }
}

TEST(ReverseFlow, FlowOfEverythingIsAligned) {
  ForwardFlowOptions global;
  global.regional = false;
  const Case c = flowed(global);
  const ReverseFlowResult r = run(c, {});
  EXPECT_TRUE(r.aligned);
  EXPECT_GT(r.quality.area_p01, 0.6);
  const Eigen::RowVector3d apart = r.U0.colwise().mean() - c.surface.V.colwise().mean();
  EXPECT_LT(apart.norm(), 0.1);
}

TEST(ReverseFlow, SameBytesOnAnyNumberOfThreads) {
  const Case c = flowed();
  ReverseFlowOptions options;
  options.final_iterations = 25;
  VertexMatrix first;
  for (int threads : {1, 2, 3, 8}) {
    const ReverseFlowResult r = run(c, options, threads);
    if (threads == 1) first = r.U0;
    EXPECT_EQ(r.U0, first) << threads << " threads";
  }
}

TEST(ReverseFlow, PowerOfTwoScaleChangesNothingElse) {
  Case c = flowed();
  ReverseFlowOptions options;
  options.final_iterations = 20;
  const ReverseFlowResult a = run(c, options);
  c.surface.V *= 0.125;
  c.forward.V *= 0.125;
  const ReverseFlowResult b = run(c, options);
  EXPECT_EQ(b.U0, a.U0 * 0.125);
}

TEST(ReverseFlow, NothingToDo) {
  Case c;
  c.surface = test::icosphere(2);
  c.forward.V = c.surface.V;
  c.forward.reverse_free.assign(c.surface.V.rows(), 1);
  const ReverseFlowResult r = run(c, {});
  EXPECT_EQ(r.termination, ReverseFlowResult::Termination::nothing_to_do);
  EXPECT_EQ(r.U0, c.surface.V);
}

TEST(ReverseFlow, StopsInTimeWithWhatItHas) {
  const Case c = flowed();
  ReverseFlowOptions options;
  options.max_seconds = 1e-9;
  const ReverseFlowResult r = run(c, options);
  EXPECT_EQ(r.termination, ReverseFlowResult::Termination::time);
}

TEST(ReverseFlow, StopsWhenItsWorkIsDoneAlwaysAtTheSamePlace) {
  const Case c = flowed();
  ReverseFlowOptions options;
  options.max_work = 20 * static_cast<double>(c.surface.F.rows());
  const ReverseFlowResult r = run(c, options);
  EXPECT_EQ(r.termination, ReverseFlowResult::Termination::work);
  EXPECT_GT(r.work, options.max_work);
  const ReverseFlowResult again = run(c, options);
  EXPECT_EQ(r.iterations, again.iterations);
  EXPECT_EQ(r.U0, again.U0);
}

TEST(ReverseFlow, LockingIsNoticedAndReported) {
  const Case c = flowed();
  ReverseFlowOptions options;
  options.lock_halvings = 0;  // every iteration counts
  options.lock_iterations = 5;
  const ReverseFlowResult r = run(c, options);
  EXPECT_EQ(r.termination, ReverseFlowResult::Termination::locked);
  EXPECT_TRUE(r.locked);
  EXPECT_EQ(r.iterations, 5);
}

TEST(ReverseFlow, QualityOfAKnownStretch) {
  const Surface s = test::icosphere(2);
  const FlowQuality q = measure_quality(2 * s.V, s.V, s.F);
  for (double area : {q.area_p01, q.area_p50, q.area_p99}) EXPECT_NEAR(area, 4, 1e-9);
  for (double edge : {q.edge_p01, q.edge_p50, q.edge_p99}) EXPECT_NEAR(edge, 2, 1e-9);
  EXPECT_EQ(q.area_within_20, 0);
}

TEST(ReverseFlow, ErrorsAreValues) {
  const Case c = flowed();
  const auto code = [&](const VertexMatrix& start, const std::vector<char>& free,
                        const ReverseFlowOptions& options, const RunContext& context) {
    const auto r = reverse_flow(c.surface, start, c.states, free, options, context);
    return r.ok() ? ErrorCode::internal : r.error().code;
  };
  const std::vector<char>& free = c.forward.reverse_free;
  EXPECT_EQ(code(c.surface.V, free, {}, {}), ErrorCode::bad_input);  // crosses itself
  VertexMatrix nan = c.forward.V;
  nan(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(code(nan, free, {}, {}), ErrorCode::bad_input);
  EXPECT_EQ(code(c.forward.V, std::vector<char>(free.size(), 0), {}, {}), ErrorCode::bad_input);
  EXPECT_EQ(code(c.forward.V, {}, {}, {}), ErrorCode::bad_input);
  ReverseFlowOptions wrong;
  wrong.kappa = 0;
  EXPECT_EQ(code(c.forward.V, free, wrong, {}), ErrorCode::usage);
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(code(c.forward.V, free, {}, context), ErrorCode::interrupted);
  RunContext late;
  late.deadline = RunContext::Clock::now();
  EXPECT_EQ(code(c.forward.V, free, {}, late), ErrorCode::limit);
}

TEST(ReverseFlow, LaddersHaveTheSameLength) {
  EXPECT_EQ(reverse_flow_ladder().size(), forward_flow_ladder().size());
  for (const auto& options : reverse_flow_ladder()) EXPECT_TRUE(options.validate().ok());
  EXPECT_TRUE(paper_reverse_flow().validate().ok());
}

}  // namespace
}  // namespace overtet
