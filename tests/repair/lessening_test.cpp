#include "src/repair/lessening.h"
#include "tests/repair/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "src/certificates/diagnose.h"
#include "src/repair/repair.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using test::verdict_of;

// A sphere of which one vertex is pulled through the far side, and some around it after it.
Surface speck(double depth, double width) {
  Surface s = test::sphere(3);
  Index top = 0, bottom = 0;
  s.V.col(2).maxCoeff(&top);
  s.V.col(2).minCoeff(&bottom);
  const Eigen::RowVector3d from = s.V.row(top),
                           to = s.V.row(bottom) + Eigen::RowVector3d(0.011, 0.017, -depth);
  for (Index v = 0; v < s.V.rows(); ++v)
    s.V.row(v) += std::exp(-(s.V.row(v) - from).squaredNorm() / (width * width)) * (to - from);
  return s;
}

// Far more than it takes: all of the input's ball is put back.
VertexMatrix far_repair(const Surface& s) {
  const Surface ball = test::sphere(3);
  return 0.9 * ball.V + 0.1 * s.V;
}

TEST(Lessening, MovesLessAndNeverFurther) {
  for (const double depth : {1e-2, 0.1})
    for (const double width : {1e-3, 0.3}) {
      SCOPED_TRACE(testing::Message() << depth << " deep, " << width << " wide");
      const Surface s = speck(depth, width);
      ASSERT_EQ(verdict_of(s), Verdict::infeasible);
      const VertexMatrix moved = far_repair(s);
      ASSERT_NE(verdict_of({moved, s.F}), Verdict::infeasible);
      const auto r = lessen(s, moved, {}, {});
      ASSERT_TRUE(r.ok()) << r.error().message;
      EXPECT_TRUE(r.value().lessened);
      const Verdict verdict = verdict_of({r.value().V, s.F});
      EXPECT_TRUE(verdict == Verdict::feasible || verdict == Verdict::embedded) << verdict_name(verdict);
      const Eigen::VectorXd before = (moved - s.V).rowwise().norm(),
                            after = (r.value().V - s.V).rowwise().norm();
      EXPECT_TRUE((after.array() <= before.array() * (1 + 1e-12)).all());
      EXPECT_LT((after.array() > 0).count(), (before.array() > 0).count() / 2);
      EXPECT_LE(after.maxCoeff(), before.maxCoeff());
    }
}

TEST(Lessening, AllThatNeedNotMoveGoesHome) {
  // Nothing objects to the ball itself, wherever it was.
  const Surface s = test::sphere(3);
  const auto r = lessen(s, 0.8 * s.V, {}, {});
  ASSERT_TRUE(r.ok());
  EXPECT_EQ(r.value().V, s.V);
}

TEST(Lessening, NothingIsDoneWhereTheStartIsWrongOrWorkIsShort) {
  const Surface s = speck(1e-2, 1e-3);
  const auto wrong = lessen(s, s.V, {}, {});
  ASSERT_TRUE(wrong.ok());
  EXPECT_FALSE(wrong.value().lessened);
  EXPECT_EQ(wrong.value().V, s.V);
  LessenOptions none;
  none.work = 0;
  const VertexMatrix moved = far_repair(s);
  const auto idle = lessen(s, moved, none, {});
  ASSERT_TRUE(idle.ok());
  EXPECT_EQ(idle.value().V, moved);
  EXPECT_FALSE(lessen(s, VertexMatrix::Zero(3, 3), {}, {}).ok());
}

TEST(Lessening, SameBytesOnAnyNumberOfThreadsAndStopsWhenAsked) {
  const Surface s = speck(1e-1, 0.3);
  RunContext one, four, late;
  one.threads = 1;
  four.threads = 4;
  const VertexMatrix moved = far_repair(s);
  const auto a = lessen(s, moved, {}, one), b = lessen(s, moved, {}, four);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.value().V, b.value().V);
  late.deadline = RunContext::Clock::now();
  const auto cut = lessen(s, moved, {}, late);
  ASSERT_TRUE(cut.ok());
  EXPECT_TRUE(cut.value().cut_by_time);
  EXPECT_EQ(cut.value().V, moved);
  std::atomic<bool> cancel{true};
  RunContext stopped;
  stopped.cancel = &cancel;
  const auto interrupted = lessen(s, moved, {}, stopped);
  ASSERT_FALSE(interrupted.ok());
  EXPECT_EQ(interrupted.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace overtet
