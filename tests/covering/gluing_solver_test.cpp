#include "src/covering/gluing_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace overtet {
namespace {

// Regions with three options each; a condition forbids some pairs of options of two regions. What is accepted
// in the end has an even or an odd sum, or any.
struct TablePuzzle {
  struct Condition {
    Index a, b;
    bool allowed[3][3];
  };
  std::vector<Condition> conditions;
  std::vector<Index> chosen;
  std::vector<double> weight;
  std::vector<char> listed;  // regions that are not have many options at first
  int parity = -1;
  std::int64_t choices = 0, most = 1'000'000;

  bool holds(const Condition& c) const {
    return chosen[c.a] < 0 || chosen[c.b] < 0 || c.allowed[chosen[c.a]][chosen[c.b]];
  }
  bool holds() const {
    return std::all_of(conditions.begin(), conditions.end(), [&](const Condition& c) { return holds(c); });
  }
  bool right_sum() const {
    int sum = 0;
    for (const Index o : chosen) sum += o;
    return parity < 0 || sum % 2 == parity;
  }
  bool brute_force(std::size_t region = 0) {
    if (region == chosen.size()) return right_sum();
    bool found = false;
    for (Index o = 0; o < 3 && !found; ++o) {
      chosen[region] = o;
      found = holds() && brute_force(region + 1);
    }
    chosen[region] = -1;
    return found;
  }

  bool is_open(Index r) const { return chosen[r] < 0; }
  std::optional<std::vector<Index>> possible(Index r, Index& blame) {
    if (!listed[r]) return std::nullopt;
    std::vector<Index> out;
    for (Index o = 0; o < 3; ++o) {
      chosen[r] = o;
      bool fits = true;
      for (std::size_t k = 0; k < conditions.size() && fits; ++k)
        if (!holds(conditions[k])) fits = false, blame = static_cast<Index>(k);
      if (fits) out.push_back(o);
    }
    chosen[r] = -1;
    return out;
  }
  bool list_options(Index r) {
    listed[r] = 1;
    return true;
  }
  void choose(Index r, Index option) { chosen[r] = option; }
  void clear(Index r) { chosen[r] = -1; }
  double rank(Index, std::size_t options) const { return static_cast<double>(options); }
  template <class F>
  void each_beside(Index r, F&& f) const {
    for (const Condition& c : conditions)
      if (c.a == r || c.b == r) f(c.a == r ? c.b : c.a, 1);
  }
  template <class F>
  void weigh(Index condition, F&& again) {
    ++weight[condition];
    again(conditions[condition].a);
    again(conditions[condition].b);
  }
  bool accepts() const { return right_sum(); }
  bool exhausted() { return ++choices > most; }
};

TablePuzzle random_puzzle(unsigned seed) {
  std::mt19937 random(seed);
  TablePuzzle p;
  const int n = 3 + static_cast<int>(random() % 5);
  p.chosen.assign(n, -1);
  for (int i = 0; i < n; ++i) p.listed.push_back(random() % 4 != 0);
  const int conditions = n + static_cast<int>(random() % (2 * n));
  for (int k = 0; k < conditions; ++k) {
    TablePuzzle::Condition c;
    c.a = static_cast<Index>(random() % n);
    c.b = static_cast<Index>((c.a + 1 + random() % (n - 1)) % n);
    for (auto& row : c.allowed)
      for (bool& x : row) x = random() % 5 > 1;
    p.conditions.push_back(c);
  }
  p.weight.assign(p.conditions.size(), 1);
  p.parity = static_cast<int>(random() % 3) - 1;
  return p;
}

TEST(GluingSolver, FindsWhatBruteForceFinds) {
  int found = 0, none = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    TablePuzzle p = random_puzzle(seed);
    const bool want = p.brute_force();
    std::vector<Index> all(p.chosen.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
    const SolverAnswer got =
        GluingSolver(p, all).run(seed % 2 == 0 ? FirstLook::at_all : FirstLook::until_stuck);
    EXPECT_EQ(got, want ? SolverAnswer::found : SolverAnswer::none) << seed;
    (want ? found : none) += 1;
    const bool all_chosen = std::none_of(p.chosen.begin(), p.chosen.end(), [](Index o) { return o < 0; });
    EXPECT_EQ(all_chosen, want) << seed;
    if (want) EXPECT_TRUE(p.holds() && p.right_sum()) << seed;
  }
  EXPECT_GT(found, 50);
  EXPECT_GT(none, 50);
}

TEST(GluingSolver, GivesUpWhenToldAndLeavesNothingChosen) {
  int given_up = 0;
  for (unsigned seed = 0; seed < 50; ++seed) {
    TablePuzzle p = random_puzzle(seed);
    p.most = 2;
    std::vector<Index> all(p.chosen.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
    if (GluingSolver(p, all).run(FirstLook::until_stuck) != SolverAnswer::too_long) continue;
    ++given_up;
    EXPECT_TRUE(std::all_of(p.chosen.begin(), p.chosen.end(), [](Index o) { return o < 0; }));
  }
  EXPECT_GT(given_up, 10);
}

// A chain of cells 0 - 1 - 2 - 3, and one more region between 1 and 3.
TEST(GluingSolver, NamesOneSideOfATree) {
  const std::vector<std::array<Index, 2>> cells{{0, 1}, {2, 1}, {2, 3}, {1, 3}, {-1, 0}};
  const std::vector<int> layers{1, 2, 3, 4};
  const std::vector<Named> named = name_layers({0, 1, 2, 3, 4}, cells, layers);
  EXPECT_EQ(named[0], Named::back);   // 1 gets its names from 0
  EXPECT_EQ(named[1], Named::front);  // 2 from 1
  EXPECT_EQ(named[2], Named::neither);
  EXPECT_EQ(named[3], Named::back);  // 3 from 1, which comes before 2
  EXPECT_EQ(named[4], Named::neither);
}

}  // namespace
}  // namespace overtet
