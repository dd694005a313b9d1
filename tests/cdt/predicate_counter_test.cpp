#include "src/cdt/predicate_counter.h"

#include <gtest/gtest.h>
#include <tetgen.h>
#include <unistd.h>

#include <cstdint>

namespace overtet {
namespace {

[[noreturn]] void leave() { _exit(42); }

double point[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {.2, .2, .2}};

void call_both() {
  // The sign is TetGen's own, also by way of the counting function.
  ASSERT_LT(orient3d(point[0], point[1], point[2], point[3]), 0);
  ASSERT_LT(insphere(point[0], point[1], point[2], point[3], point[4]), 0);
}

TEST(PredicateWatch, CountsAndHandsOn) {
  exactinit(0, 0, 0, 1, 1, 1);
  const std::int64_t before = predicate_watch::calls();
  call_both();
  EXPECT_EQ(before + 2, predicate_watch::calls());
}

TEST(PredicateWatch, EndsAfterSoManyCalls) {
  exactinit(0, 0, 0, 1, 1, 1);
  const auto work = [] {
    predicate_watch::begin(9, 1000, leave);
    for (int i = 0; i < 5; ++i) call_both();
    _exit(1);
  };
  EXPECT_EXIT(work(), testing::ExitedWithCode(42), "");
  predicate_watch::begin(10, 1000, leave);
  for (int i = 0; i < 5; ++i) call_both();
  predicate_watch::end();
  call_both();
}

// Of two surfaces almost in one place: TetGen went around an edge for ever.
TEST(PredicateWatch, EndsALoopWithoutCalls) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "Under the thread sanitizer a loop without calls gets no signal.";
#endif
  const auto work = [] {
    predicate_watch::begin(1000, 1, leave);
    for (volatile bool on = true; on;) {
    }
  };
  EXPECT_EXIT(work(), testing::ExitedWithCode(42), "");
}

}  // namespace
}  // namespace overtet
