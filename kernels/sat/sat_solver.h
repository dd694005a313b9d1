// Satisfiability of a propositional formula, by CaDiCaL (a solver that learns clauses from conflicts).
//
// A variable has a number from 1 on; a literal is the number, or its negative for "not". The same formula,
// built in the same order, has the same answer and the same values everywhere.
//
// Source: Biere, Fazekas, Fleury, Heisinger 2020, "CaDiCaL, Kissat, Paracooba, Plingeling and Treengeling".
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>

namespace overtet {

using Literal = int;

enum class SatAnswer { satisfiable, unsatisfiable, unknown };

class SatSolver {
 public:
  SatSolver();
  ~SatSolver();
  SatSolver(const SatSolver&) = delete;
  SatSolver& operator=(const SatSolver&) = delete;

  Literal new_variable() { return ++variables_; }

  // At least one of them holds.
  void add(std::span<const Literal> clause);
  void add(std::initializer_list<Literal> clause) { add(std::span<const Literal>(clause)); }
  // At most one of them holds; exactly one does. Pairwise: for short lists.
  void at_most_one(std::span<const Literal> literals);
  void exactly_one(std::span<const Literal> literals);

  // What a value is tried with first.
  void prefer(Literal literal);

  // What must hold in the next call of solve, besides all clauses.
  void assume(Literal literal);

  // unknown: after so many conflicts, or when `stop` (called now and then) says so.
  SatAnswer solve(std::int64_t most_conflicts, const std::function<bool()>& stop);

  // pre: the last answer was satisfiable, and nothing has been added since.
  bool holds(Literal literal) const;

  std::int64_t literals() const { return literals_; }  // of all clauses: how large the formula is

 private:
  struct Engine;
  std::unique_ptr<Engine> engine_;
  int variables_ = 0;
  std::int64_t literals_ = 0;
};

}  // namespace overtet
