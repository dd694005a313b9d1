// Ten generated surfaces, each damaged in every way and several times.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

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

// Points of a small grid, some of them twice.
VertexMatrix some_points(Index n, std::mt19937_64& random) {
  VertexMatrix V(n, 3);
  for (Index v = 0; v < n; ++v) V.row(v) << double(random() % 3), double(random() % 3), double(random() % 3);
  return V;
}

// Whatever is given: a surface comes out, or what is wrong with it.
TEST(RandomSoups, AreCleanedOrRefused) {
  const std::uint64_t seed = 7;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (int i = 0; i < 3000; ++i) {
    Surface s;
    s.V = some_points(static_cast<Index>(4 + random() % 8), random);
    s.F.resize(static_cast<Index>(4 + random() % 24), 3);
    for (Index f = 0; f < s.F.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        s.F(f, k) = static_cast<Index>(random() % static_cast<std::uint64_t>(s.V.rows()));
    const Result<Cleanup> c = clean_up(s);
    ASSERT_TRUE(c.ok()) << c.error().message;
    if (!c.value().problem) EXPECT_EQ(test::wrong_with(c.value(), s), "") << i;
    for (const Defect& d : c.value().defects) EXPECT_FALSE(d.message.empty()) << name_of(d.kind);
  }
}

// Tets that have corners, edges and faces in common, each with its four faces, some inside out: every edge
// has an even number of faces.
TEST(RandomSoups, OfTetsAreCleanedOrRefused) {
  const std::uint64_t seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  int cleaned = 0, all = 0;
  for (int i = 0; i < 2000; ++i) {
    Surface s;
    s.V = some_points(7, random);
    std::vector<std::array<Index, 3>> faces;
    const int tets = static_cast<int>(1 + random() % 5);
    for (int t = 0; t < tets; ++t) {
      std::array<Index, 7> order{0, 1, 2, 3, 4, 5, 6};
      std::shuffle(order.begin(), order.end(), random);
      const auto [a, b, c, d, e, f, g] = order;
      faces.insert(faces.end(), {{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}});
    }
    s.F.resize(static_cast<Index>(faces.size()), 3);
    for (std::size_t f = 0; f < faces.size(); ++f)
      for (int k = 0; k < 3; ++k) s.F(static_cast<Index>(f), k) = faces[f][k];
    if (random() % 2) std::swap(s.F(0, 0), s.F(0, 1));
    const Result<Cleanup> c = clean_up(s);
    ASSERT_TRUE(c.ok()) << c.error().message;
    ++all;
    if (c.value().problem) continue;
    ++cleaned;
    EXPECT_EQ(test::wrong_with(c.value(), s), "") << i;
    const Result<Cleanup> again = clean_up(c.value().surface);
    ASSERT_TRUE(again.ok());
    EXPECT_FALSE(again.value().changed())
        << i << ": " << c.value().summary() << " " << again.value().summary();
  }
  EXPECT_GT(cleaned, all / 4);
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
