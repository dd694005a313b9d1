#include "src/immersion/edge_fan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace overtet {
namespace {

std::set<std::vector<int>> listed(const Region& region, Named named) {
  std::deque<Gluing> gluings;
  enumerate_gluings(region, named, gluings);
  std::set<std::vector<int>> keys;
  for (const Gluing& g : gluings) {
    for (int f = 0; f < region.front_winding; ++f)
      EXPECT_TRUE(g.back_of[f] < 0 || g.front_of[g.back_of[f]] == f);
    for (int b = 0; b < region.back_winding; ++b)
      EXPECT_TRUE(g.front_of[b] < 0 || g.back_of[g.front_of[b]] == b);
    for (int s = 0; s < static_cast<int>(region.signs.size()); ++s) {
      EXPECT_EQ(std::count(g.front_of.begin(), g.front_of.end(), -1 - s), region.signs[s] > 0);
      EXPECT_EQ(std::count(g.back_of.begin(), g.back_of.end(), -1 - s), region.signs[s] < 0);
    }
    std::vector<int> key = g.back_of;
    key.insert(key.end(), g.front_of.begin(), g.front_of.end());
    EXPECT_TRUE(keys.insert(std::move(key)).second) << "listed twice";
  }
  EXPECT_EQ(static_cast<double>(keys.size()), count_gluings(region, named));
  return keys;
}

// What remains of gluings when the copies of one side have no names: where each copy of the other side and
// each slot goes, numbered as met.
std::vector<int> without_names(const std::vector<int>& key, int front, bool back_side) {
  const std::vector<int> back_of(key.begin(), key.begin() + front), front_of(key.begin() + front, key.end());
  std::vector<int> image(back_side ? back_of : front_of);
  for (int& x : image) x = std::min(x, 0);  // matched, or the slot where it ends
  return image;
}

TEST(Fan, ListsEveryGluingOfARegionOnceUpToTheNamesOfOneSide) {
  for (int front = 0; front <= 4; ++front)
    for (const std::vector<int>& signs : std::vector<std::vector<int>>{{1}, {-1}, {1, 1}, {1, -1}, {-1, 1}}) {
      int jump = 0;
      for (const int s : signs) jump += s;
      if (front + jump < 0) continue;
      Region region;
      region.front_winding = front;
      region.back_winding = front + jump;
      region.signs = signs;
      const auto all = listed(region, Named::neither);
      for (const Named named : {Named::front, Named::back}) {
        const auto some = listed(region, named);
        EXPECT_TRUE(std::includes(all.begin(), all.end(), some.begin(), some.end()));
        const bool back = named == Named::back;
        std::set<std::vector<int>> classes, represented;
        for (const auto& key : all) classes.insert(without_names(key, front, back));
        for (const auto& key : some)
          EXPECT_TRUE(represented.insert(without_names(key, front, back)).second) << "one class twice";
        EXPECT_EQ(classes, represented);
      }
    }
}

// A sheet folded along an edge: outside on one side of both leaves, one copy of the solid on the other.
TEST(Fan, OneSheetAroundAnEdgeNeedsTheTurnsThatItMakes) {
  Region region;
  region.front_winding = 0;
  region.back_winding = 1;
  region.signs = {1};
  std::deque<Gluing> gluings;
  enumerate_gluings(region, Named::neither, gluings);
  ASSERT_EQ(gluings.size(), 1u);
  Fan fan;
  fan.leaves = {{0, false, {0}}, {0, true, {0}}};
  fan.arc = {{{-1, 2 * 1 + 0}}, {{2 * 0 + 1, -1}}};
  fan.passes = {{0, 0, 1, 0, 0}};
  const std::vector<const Gluing*> chosen{&gluings[0]};
  EXPECT_TRUE(satisfied(fan, chosen, {region}));
  EXPECT_FALSE(satisfied(fan, chosen, {region}, 1));
}

}  // namespace
}  // namespace overtet
