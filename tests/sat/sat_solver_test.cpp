#include "kernels/sat/sat_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <vector>

namespace overtet {
namespace {

using Clauses = std::vector<std::vector<Literal>>;

// Bit i of `values` is that of variable i + 1.
bool holds_under(const Clauses& clauses, unsigned values) {
  return std::all_of(clauses.begin(), clauses.end(), [&](const auto& clause) {
    return std::any_of(clause.begin(), clause.end(),
                       [&](Literal x) { return ((values >> (std::abs(x) - 1) & 1) != 0) == (x > 0); });
  });
}

TEST(SatSolver, AgreesWithTryingAllValues) {
  const std::uint64_t seed = 11;
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::mt19937_64 random(seed);
  int satisfiable = 0, not_satisfiable = 0;
  for (int round = 0; round < 300; ++round) {
    const int n = 3 + static_cast<int>(random() % 6);
    Clauses clauses(static_cast<std::size_t>(n) * 4);
    SatSolver solver;
    for (int i = 0; i < n; ++i) solver.new_variable();
    for (auto& clause : clauses) {
      for (int k = 0; k < 3; ++k) {
        const Literal x = 1 + static_cast<int>(random() % static_cast<unsigned>(n));
        clause.push_back(random() % 2 ? x : -x);
      }
      solver.add(clause);
    }
    bool any = false;
    for (unsigned values = 0; values < 1u << n; ++values) any = any || holds_under(clauses, values);
    const SatAnswer answer = solver.solve(100'000, {});
    ASSERT_EQ(answer, any ? SatAnswer::satisfiable : SatAnswer::unsatisfiable) << "round " << round;
    ++(any ? satisfiable : not_satisfiable);
    if (!any) continue;
    unsigned found = 0;
    for (int i = 0; i < n; ++i) found |= solver.holds(i + 1) ? 1u << i : 0u;
    EXPECT_TRUE(holds_under(clauses, found));
  }
  EXPECT_GT(satisfiable, 20);
  EXPECT_GT(not_satisfiable, 20);
}

TEST(SatSolver, ExactlyOneAndAssumptions) {
  SatSolver solver;
  std::vector<Literal> x;
  for (int i = 0; i < 5; ++i) x.push_back(solver.new_variable());
  solver.exactly_one(x);
  for (const Literal wanted : x) {
    solver.assume(wanted);
    ASSERT_EQ(solver.solve(100, {}), SatAnswer::satisfiable);
    for (const Literal other : x) EXPECT_EQ(solver.holds(other), other == wanted);
  }
  solver.assume(x[0]);
  solver.assume(x[1]);
  EXPECT_EQ(solver.solve(100, {}), SatAnswer::unsatisfiable);
  EXPECT_EQ(solver.solve(100, {}), SatAnswer::satisfiable);  // assumptions hold for one call
}

// Nine pigeons in eight holes: a formula that takes many conflicts.
TEST(SatSolver, GivesUpWhenAskedTo) {
  const auto pigeons = [](SatSolver& solver) {
    std::vector<std::vector<Literal>> at(9, std::vector<Literal>(8));
    for (auto& row : at) {
      for (Literal& x : row) x = solver.new_variable();
      solver.add(row);
    }
    for (int hole = 0; hole < 8; ++hole) {
      std::vector<Literal> all;
      for (const auto& row : at) all.push_back(row[hole]);
      solver.at_most_one(all);
    }
  };
  SatSolver few, stopped;
  pigeons(few);
  EXPECT_EQ(few.solve(5, {}), SatAnswer::unknown);
  pigeons(stopped);
  EXPECT_EQ(stopped.solve(1'000'000, [] { return true; }), SatAnswer::unknown);
}

}  // namespace
}  // namespace overtet
