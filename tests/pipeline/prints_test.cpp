// Flat prints with caps of needles.
#include <gtest/gtest.h>

#include "overtet/verification.h"
#include "src/pipeline/pipeline.h"
#include "tests/support/models.h"
#include "tests/support/prints.h"

namespace overtet {
namespace {

// Flips among needles of 36,000:1 did not end, and neither did those among the thinner faces of a gear.
TEST(Prints, FlipsAmongTheNeedlesOfFlatCapsNeverEnded) {
  const Surface fan = test::rounded_plate(921, test::Caps::fan);
  MeshingOptions options;
  options.improve_degrees = 0;
  for (const Surface& s :
       {fan, test::rounded_plate(921, test::Caps::strip), test::rounded_plate(921, test::Caps::fan, 0.02),
        test::transformed(fan, test::some_rotation(1), {1, 2, 3}), test::ring_plate(1500),
        test::gear_plate(2000)}) {
    const PipelineResult r = run_pipeline(s, options, {});
    ASSERT_TRUE(r.ok()) << r.report.message;
    const VerifyResult v = verify(s, r.mesh);
    EXPECT_TRUE(v.ok()) << v.summary();
  }
}

TEST(Prints, TheQualityPassEndsAmongNeedles) {
  const Surface s = test::rounded_plate(100, test::Caps::fan);
  RunContext many;
  many.threads = 4;
  const PipelineResult one = run_pipeline(s, {}, {}), other = run_pipeline(s, {}, many);
  ASSERT_TRUE(one.ok()) << one.report.message;
  EXPECT_EQ(one.report.result_hash, other.report.result_hash);
  EXPECT_TRUE(verify(s, one.mesh).ok());
}

}  // namespace
}  // namespace overtet
