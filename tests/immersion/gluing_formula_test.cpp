#include "src/immersion/gluing_formula.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>

namespace overtet {
namespace {

// One edge with leaves around it, and sheets that pass over it in pairs; every leaf has a region and every
// sector a cell of its own.
struct OneEdge {
  std::vector<Region> regions;
  std::vector<Index> winding;  // per cell
  SheetPuzzle puzzle;
};

OneEdge random_edge(std::mt19937_64& random, int sheets) {
  const int n = 2 * sheets;
  std::vector<int> sign;  // +1: the inside is the sector after the leaf
  for (int i = 0; i < n; ++i) sign.push_back(i < sheets ? 1 : -1);
  std::shuffle(sign.begin(), sign.end(), random);
  std::vector<int> winding{0};  // before each leaf
  for (int i = 0; i + 1 < n; ++i) winding.push_back(winding.back() + sign[i]);
  const int least = *std::min_element(winding.begin(), winding.end());
  const int lowest = static_cast<int>(random() % 2);
  for (int& w : winding) w += lowest - least;
  OneEdge out;
  Fan fan;
  for (int i = 0; i < n; ++i) {
    const int after = (i + 1) % n, before = (i + n - 1) % n;
    Region r;
    r.front_winding = winding[i], r.back_winding = winding[after];
    r.signs = {sign[i]};
    out.regions.push_back(r);
    out.winding.push_back(winding[i]);
    out.puzzle.cells.push_back({i, after});
    fan.leaves.push_back({i, false, {0}});
    fan.arc.push_back({winding[i] > 0 ? 2 * before + 1 : -1, winding[after] > 0 ? 2 * after : -1});
  }
  std::vector<int> begin, end;
  for (int i = 0; i < n; ++i) (sign[i] > 0 ? begin : end).push_back(i);
  std::shuffle(end.begin(), end.end(), random);
  for (int p = 0; p < sheets; ++p)
    fan.passes.push_back({begin[p], 0, end[p], 0, random() % 4 == 0 ? static_cast<int>(random() % 3) : 0});
  out.puzzle.fans.push_back(fan);
  return out;
}

// Calls f with every choice of gluings, until it returns true.
template <class F>
bool any_choice(const OneEdge& e, F&& f) {
  std::vector<std::deque<Gluing>> options(e.regions.size());
  for (std::size_t i = 0; i < e.regions.size(); ++i)
    enumerate_gluings(e.regions[i], Named::neither, options[i]);
  std::vector<const Gluing*> chosen(e.regions.size(), nullptr);
  const auto go = [&](auto&& self, std::size_t i) -> bool {
    if (i == chosen.size()) return f(chosen);
    return std::any_of(options[i].begin(), options[i].end(), [&](const Gluing& g) {
      chosen[i] = &g;
      return self(self, i + 1);
    });
  };
  return go(go, 0);
}

std::vector<const Gluing*> pointers(const std::vector<Gluing>& gluings) {
  std::vector<const Gluing*> out;
  for (const Gluing& g : gluings) out.push_back(&g);
  return out;
}

// That the formula has the answer that trying all gluings has; whether there is one.
bool agrees(const OneEdge& e, const Fan& fan, int variant) {
  const bool any = any_choice(e, [&](const auto& chosen) { return satisfied(fan, chosen, e.regions); });
  const FormulaAnswer answer = solve_as_formula(e.regions, e.winding, e.puzzle, variant, {});
  EXPECT_EQ(answer.verdict, any ? FormulaAnswer::Verdict::found : FormulaAnswer::Verdict::none);
  if (any && !answer.gluings.empty()) EXPECT_TRUE(satisfied(fan, pointers(answer.gluings), e.regions));
  return any;
}

TEST(GluingFormula, AgreesWithAllGluingsAroundOneEdge) {
  const std::uint64_t seed = 3;
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::mt19937_64 random(seed);
  int found = 0, none = 0;
  for (int round = 0; round < 400; ++round) {
    const OneEdge e = random_edge(random, 1 + static_cast<int>(random() % 2));
    SCOPED_TRACE(round);
    ++(agrees(e, e.puzzle.fans[0], 0) ? found : none);
  }
  EXPECT_GT(found, 50);
  EXPECT_GT(none, 20);
}

// The same, where the first sheet may turn as often as it likes at one edge, and must turn a given number of
// times at another one between the same regions.
TEST(GluingFormula, FindsTheTurnsOfAnEdgeThatMayBeWound) {
  const std::uint64_t seed = 4;
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::mt19937_64 random(seed);
  int turned = 0, none = 0;
  for (int round = 0; round < 400; ++round) {
    OneEdge e = random_edge(random, 1 + static_cast<int>(random() % 2));
    Fan& fan = e.puzzle.fans[0];
    fan.passes[0].turns = static_cast<int>(random() % 3);
    FreeFan free{fan, std::vector<Index>(fan.passes.size(), -1)};
    free.edges[0] = 0;
    e.puzzle.free_fans.push_back(free);
    e.puzzle.free_edges = 1;
    e.puzzle.pierced = {0};
    SCOPED_TRACE(round);
    const bool any = agrees(e, fan, 0);
    EXPECT_EQ(agrees(e, fan, 1), any);
    turned += any && fan.passes[0].turns > 0;
    none += !any;
  }
  EXPECT_GT(turned, 5);
  EXPECT_GT(none, 5);
}

TEST(GluingFormula, StopsWhenTheContextSaysSo) {
  std::mt19937_64 random(6);
  OneEdge e = random_edge(random, 1);
  e.puzzle.free_fans.push_back({e.puzzle.fans[0], {0}});
  e.puzzle.fans.clear();
  e.puzzle.free_edges = 1;
  e.puzzle.pierced = {0};
  const std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  const FormulaAnswer answer = solve_as_formula(e.regions, e.winding, e.puzzle, 0, context);
  EXPECT_EQ(answer.verdict, FormulaAnswer::Verdict::undecided);
  ASSERT_TRUE(answer.stop.has_value());
  EXPECT_EQ(answer.stop->code, ErrorCode::interrupted);
}

// Turns that nothing asks for are taken back.
TEST(GluingFormula, NoEdgeIsWoundInVain) {
  const std::uint64_t seed = 5;
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::mt19937_64 random(seed);
  int found = 0;
  for (int round = 0; round < 200; ++round) {
    OneEdge e = random_edge(random, 1);
    Fan fan = e.puzzle.fans[0];
    fan.passes[0].turns = 0;
    e.puzzle.fans.clear();
    e.puzzle.free_fans.push_back({fan, {0}});
    e.puzzle.free_edges = 1;
    e.puzzle.pierced = {0};
    const FormulaAnswer answer = solve_as_formula(e.regions, e.winding, e.puzzle, 1, {});
    if (answer.verdict != FormulaAnswer::Verdict::found) continue;
    EXPECT_TRUE(satisfied(fan, pointers(answer.gluings), e.regions)) << "round " << round;
    ++found;
  }
  EXPECT_GT(found, 100);
}

}  // namespace
}  // namespace overtet
