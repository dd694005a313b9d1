#include "kernels/sat/sat_solver.h"

#include <algorithm>
#include <cadical.hpp>
#include <limits>

namespace overtet {

struct SatSolver::Engine {
  mutable CaDiCaL::Solver solver;
};

// Formulas here are large and easy, and mostly satisfiable. To simplify them between searches takes longer
// than to solve them.
SatSolver::SatSolver() : engine_(std::make_unique<Engine>()) {
  engine_->solver.set("quiet", 1);
  engine_->solver.set("inprocessing", 0);
  engine_->solver.set("stabilizeonly", 1);
}
SatSolver::~SatSolver() = default;

void SatSolver::add(std::span<const Literal> clause) {
  for (const Literal x : clause) engine_->solver.add(x);
  engine_->solver.add(0);
  literals_ += static_cast<std::int64_t>(clause.size());
}

void SatSolver::at_most_one(std::span<const Literal> literals) {
  for (std::size_t i = 0; i < literals.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) add({-literals[i], -literals[j]});
}

void SatSolver::exactly_one(std::span<const Literal> literals) {
  add(literals);
  at_most_one(literals);
}

void SatSolver::prefer(Literal literal) { engine_->solver.phase(literal); }

void SatSolver::assume(Literal literal) { engine_->solver.assume(literal); }

SatAnswer SatSolver::solve(std::int64_t most_conflicts, const std::function<bool()>& stop) {
  struct Terminator : CaDiCaL::Terminator {
    explicit Terminator(const std::function<bool()>& wanted) : stop(wanted) {}
    bool terminate() override { return stop(); }
    const std::function<bool()>& stop;
  } terminator(stop);
  CaDiCaL::Solver& solver = engine_->solver;
  constexpr std::int64_t most = std::numeric_limits<int>::max();
  solver.limit("conflicts", static_cast<int>(std::min(most_conflicts, most)));
  if (stop) solver.connect_terminator(&terminator);
  const int answer = solver.solve();
  if (stop) solver.disconnect_terminator();
  return answer == 10 ? SatAnswer::satisfiable : answer == 20 ? SatAnswer::unsatisfiable : SatAnswer::unknown;
}

bool SatSolver::holds(Literal literal) const { return engine_->solver.val(literal) > 0; }

}  // namespace overtet
