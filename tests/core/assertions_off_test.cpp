// With assertions off, as in a release build.
#undef OVERTET_ASSERTIONS
#define OVERTET_ASSERTIONS 0
#include <gtest/gtest.h>

#include "kernels/core/assertions.h"

namespace overtet {
namespace {

TEST(AssertionsOff, EvaluateNothing) {
  int evaluated = 0;
  OVERTET_EXPECTS(++evaluated > 1);
  OVERTET_ENSURES(++evaluated > 1);
  OVERTET_ASSERT(++evaluated > 1);
  EXPECT_EQ(evaluated, 0);
}

}  // namespace
}  // namespace overtet
