// With assertions on, whatever the build.
#undef OVERTET_ASSERTIONS
#define OVERTET_ASSERTIONS 1
#include "kernels/core/assertions.h"

#include <gtest/gtest.h>

namespace overtet {
namespace {

Status odd(int n) {
  if (n % 2 == 0) return Error{ErrorCode::internal, "even"};
  return success();
}

TEST(AssertionsDeathTest, SayWhereAndWhat) {
  const int three = 3;
  EXPECT_DEATH(OVERTET_EXPECTS(three > 4), "assertions_test.cpp:[0-9]+: precondition failed: three > 4");
  EXPECT_DEATH(OVERTET_ENSURES(three == 4), "postcondition failed: three == 4");
  EXPECT_DEATH(OVERTET_ASSERT(three != 3), "assertion failed: three != 3");
  EXPECT_DEATH(OVERTET_ENSURES(odd(4)), "postcondition failed: odd\\(4\\): even");
}

TEST(Assertions, LetPassWhatHolds) {
  int evaluated = 0;
  OVERTET_EXPECTS(++evaluated == 1);
  OVERTET_ENSURES(odd(3));
  OVERTET_ASSERT([&] { return ++evaluated == 2; }());
  EXPECT_EQ(evaluated, 2);
}

TEST(Assertions, TheCostlyOnesNeedTheSecondLevel) {
  int evaluated = 0;
  OVERTET_EXPECTS_COSTLY(++evaluated > 1);
  OVERTET_ENSURES_COSTLY(++evaluated > 1);
  EXPECT_EQ(evaluated, 0);
}

}  // namespace
}  // namespace overtet
