// Whether sheets can be glued along the curves: the search against all choices, and surfaces with known
// answers.
#include "src/covering/gluing.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <random>

#include "src/certificates/diagnose.h"
#include "src/covering/gluing_search.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

// Shells with 1, 2 and 3 sheets, regions between them, changes of names, and conditions that fit them.
struct Puzzle {
  std::vector<int> sheets;
  std::vector<Index> outer, inner;  // of regions, then of changes of names
  std::vector<GluingCondition> conditions;
};

Puzzle some_puzzle(std::mt19937& random) {
  const auto pick = [&](int n) { return static_cast<Index>(random() % static_cast<unsigned>(n)); };
  Puzzle p{{1, 1, 2, 2, 3, 3}, {}, {}, {}};
  const int regions = 4 + pick(3);
  for (int r = 0; r < regions; ++r) {
    const Index from = pick(4);
    p.outer.push_back(from);
    p.inner.push_back(from / 2 * 2 + 2 + pick(2));
  }
  const int names = pick(3);
  for (int k = 0; k < names; ++k) {
    p.outer.push_back(2 + pick(2));
    p.inner.push_back(p.outer.back());
  }
  const auto name_in = [&](GluingCondition& c, int sector, Index shell) {
    for (Index k = regions; k < regions + names; ++k)
      if (p.outer[k] == shell && pick(3) == 0) {
        c.names[sector] = k;
        c.backwards[sector] = static_cast<char>(pick(2));
      }
  };
  std::vector<GluingCondition> fitting;
  for (Index a = 0; a < regions; ++a)
    for (Index b = 0; b < regions; ++b) {
      if (p.outer[a] != p.outer[b]) continue;
      if (a < b && p.inner[a] == p.inner[b]) {
        GluingCondition c;
        c.regions = {a, b, -1, -1};
        c.most = pick(2);
        name_in(c, 0, p.outer[a]);
        name_in(c, 1, p.inner[a]);
        fitting.push_back(c);
      }
      for (Index d = 0; d < regions; ++d)
        for (Index e = 0; e < regions; ++e) {
          if (p.outer[d] != p.inner[b] || p.outer[e] != p.inner[a] || p.inner[d] != p.inner[e]) continue;
          GluingCondition c;
          c.regions = {a, b, d, e};
          name_in(c, 0, p.outer[a]);
          name_in(c, 1, p.inner[a]);
          name_in(c, 2, p.inner[b]);
          name_in(c, 3, p.inner[d]);
          fitting.push_back(c);
        }
    }
  std::shuffle(fitting.begin(), fitting.end(), random);
  fitting.resize(std::min<std::size_t>(fitting.size(), 3 + random() % 4));
  p.conditions = fitting;
  return p;
}

// All ways of all regions, with no thought given to names.
bool has_solution(const Puzzle& p) {
  std::vector<std::vector<Way>> ways(p.outer.size());
  for (std::size_t r = 0; r < p.outer.size(); ++r) {
    const int from = p.sheets[p.outer[r]], to = p.sheets[p.inner[r]];
    std::vector<signed char> all(static_cast<std::size_t>(to));
    std::iota(all.begin(), all.end(), static_cast<signed char>(0));
    do {
      const Way way(all.begin(), all.begin() + from);
      if (std::find(ways[r].begin(), ways[r].end(), way) == ways[r].end()) ways[r].push_back(way);
    } while (std::next_permutation(all.begin(), all.end()));
  }
  std::vector<const Way*> chosen(p.outer.size());
  std::vector<char> used(p.outer.size(), 0);
  for (const GluingCondition& c : p.conditions) c.each([&](Index r) { used[r] = 1; });
  const auto descend = [&](auto&& self, std::size_t r) -> bool {
    if (r == ways.size())
      return std::all_of(p.conditions.begin(), p.conditions.end(),
                         [&](const GluingCondition& c) { return holds(c, chosen); });
    for (const Way& way : ways[r]) {
      chosen[r] = &way;
      if (self(self, r + 1)) return true;
      if (!used[r]) break;
    }
    return false;
  };
  return descend(descend, 0);
}

// In front of each region and behind it.
std::vector<std::array<Index, 2>> cells_of(const Puzzle& p) {
  std::vector<std::array<Index, 2>> cells;
  for (std::size_t r = 0; r < p.outer.size(); ++r) cells.push_back({p.outer[r], p.inner[r]});
  return cells;
}

TEST(GluingSearch, FindsWhatAllChoicesFind) {
  const RunContext context;
  int without = 0, with = 0;
  for (unsigned seed = 0; seed < 4000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Puzzle p = some_puzzle(random);
    if (p.conditions.empty()) continue;
    const std::vector<std::array<Index, 2>> cells = cells_of(p);
    GluingSearch search(p.conditions, cells, p.sheets, context);
    const SolverAnswer answer = search.run(1'000'000);
    ASSERT_EQ(answer, has_solution(p) ? SolverAnswer::found : SolverAnswer::none);
    ++(answer == SolverAnswer::none ? without : with);
    if (answer == SolverAnswer::found) continue;
    // What the search says that it has needed has no solution, either.
    Puzzle less = p;
    less.conditions = search.needed();
    EXPECT_FALSE(has_solution(less));
  }
  EXPECT_GT(without, 200);
  EXPECT_GT(with, 200);
}

// A search that is cut short says so; it never says anything else than the whole one.
TEST(GluingSearch, GivesUpWhenTold) {
  const RunContext context;
  int given_up = 0;
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const Puzzle p = some_puzzle(random);
    const std::vector<std::array<Index, 2>> cells = cells_of(p);
    GluingSearch search(p.conditions, cells, p.sheets, context),
        whole(p.conditions, cells, p.sheets, context);
    const SolverAnswer answer = search.run(1);
    if (answer == SolverAnswer::too_long)
      ++given_up;
    else
      EXPECT_EQ(answer, whole.run(1'000'000));
  }
  EXPECT_GT(given_up, 20);
}

GluingAnswer answer_for(const Surface& s) {
  const Diagnosis d = diagnose(s, {}, {}).value();
  return check_gluing(s, d.topology.topology, *d.bvh, *d.graph, {}).value();
}

TEST(Gluing, NothingContradictsSurfacesWithAMesh) {
  for (const Surface& s :
       {test::curled_worm(420, 12), test::two_spheres(1), test::bent_slab(1), test::elbow(150, 12)}) {
    const GluingAnswer a = answer_for(s);
    EXPECT_EQ(a.verdict, GluingVerdict::open) << a.message;
  }
}

// Two tetrahedra that pierce each other, no face whole: winding numbers come from the curves.
TEST(Gluing, EveryFaceIsCrossed) {
  Surface tet;
  tet.V.resize(4, 3);
  tet.V << 1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1;
  tet.F.resize(4, 3);
  tet.F << 0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2;
  ASSERT_GT(test::signed_volume(tet), 0);
  const Surface other = test::transformed(
      tet, Eigen::AngleAxisd(1.5, Eigen::Vector3d(0.1, 0.05, 1).normalized()).toRotationMatrix(),
      {0.01, 0.02, 0.03});
  const GluingAnswer a = answer_for(test::joined(tet, other));
  EXPECT_EQ(a.verdict, GluingVerdict::open) << a.message;
  EXPECT_GT(a.parts, 8);
}

TEST(Gluing, WhatTouchesIsNotDecided) {
  const Surface box = test::box(2);
  const GluingAnswer a = answer_for(test::joined(box, box));
  EXPECT_EQ(a.verdict, GluingVerdict::undecided);
  EXPECT_NE(a.message.find("general position"), std::string::npos);
}

}  // namespace
}  // namespace overtet
