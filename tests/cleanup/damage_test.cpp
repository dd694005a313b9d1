// Ten generated surfaces, each damaged in every way and several times.
#include <gtest/gtest.h>

#include "overtet/cleanup.h"
#include "tests/cleanup/damage.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

constexpr int kTimes = 2;

class DamagedSurfaces : public ::testing::TestWithParam<test::Damage> {};

TEST_P(DamagedSurfaces, AreCleanedToWhatTheyWere) {
  const std::uint64_t seed = 20261130;
  for (const auto& [name, surface] : test::surfaces_to_damage())
    for (int time = 0; time < kTimes; ++time) {
      SCOPED_TRACE(std::string(name) + ", seed " + std::to_string(seed + time));
      std::mt19937_64 random(seed + time);
      const test::Damaged damaged = GetParam().make(surface, random);
      const Result<Cleanup> cleaned = clean_up(damaged.given);
      ASSERT_TRUE(cleaned.ok()) << cleaned.error().message;
      EXPECT_EQ(test::wrong_with(cleaned.value(), damaged), "");
      // Once cleaned is clean; and there is always something to tell.
      if (cleaned.value().problem) {
        EXPECT_FALSE(cleaned.value().problem->message.empty());
        continue;
      }
      const Result<Cleanup> again = clean_up(cleaned.value().surface);
      ASSERT_TRUE(again.ok());
      EXPECT_FALSE(again.value().changed()) << again.value().summary();
      EXPECT_EQ(cleaned.value().changed(), !cleaned.value().summary().empty());
    }
}

INSTANTIATE_TEST_SUITE_P(Damages, DamagedSurfaces, ::testing::ValuesIn(test::damages()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(DamagedSurfaces, AreMoreThanTwoHundred) {
  EXPECT_GE(test::damages().size() * test::surfaces_to_damage().size() * kTimes, 200u);
}

// Whatever the threads, and however often.
TEST(DamagedSurfaces, AreCleanedAlikeOnAnyThreads) {
  std::mt19937_64 random(3);
  const test::Damaged damaged = test::damages().back().make(test::sphere(4), random);
  RunContext one, four;
  one.threads = 1, four.threads = 4;
  const Result<Cleanup> a = clean_up(damaged.given, {}, {}, one), b = clean_up(damaged.given, {}, {}, four);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.value().surface.V, b.value().surface.V);
  EXPECT_EQ(a.value().surface.F, b.value().surface.F);
  EXPECT_EQ(a.value().vertex_of, b.value().vertex_of);
}

}  // namespace
}  // namespace overtet
