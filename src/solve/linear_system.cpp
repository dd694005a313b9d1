#include "src/solve/linear_system.h"

#include <chrono>
#include <utility>

#include "src/solve/parts.h"
#include "src/solve/tuning.h"

namespace overtet::solve_detail {

namespace {

using SolverClock = std::chrono::steady_clock;

// The seconds since `begin`, which begins anew.
double lap(SolverClock::time_point& begin) {
  const SolverClock::time_point now = SolverClock::now();
  return std::chrono::duration<double>(now - std::exchange(begin, now)).count();
}

Status solve_directly(const LinearSystem& system, LinearSolution& out, const RunContext& context) {
  auto begin = SolverClock::now();
  Result<SparseCholesky> factor = factored(system.A, context);
  if (!factor) return factor.error();
  out.solver = LinearSolver::direct;
  out.factor_entries = factor.value().factor_entries();
  out.seconds_factor += lap(begin);
  Result<Eigen::VectorXd> x = solved_by(factor.value(), system.b);
  if (!x) return x.error();
  out.x = std::move(x).value();
  const double size = system.b.norm();
  out.residual = (times(system.A, out.x) - system.b).norm() / (size > 0 ? size : 1);
  out.seconds_solve += lap(begin);
  return success();
}

// Whether it got there.
Result<bool> solve_by_multigrid(const LinearSystem& system, LinearSolution& out, const RunContext& context) {
  auto begin = SolverClock::now();
  // Both triangles, in rows and while they are turned; coarser levels are less than as much again.
  if (auto e = context.no_room_for(6 * sizeof(double) * static_cast<std::size_t>(system.A.nonZeros())))
    return *e;
  Multigrid multigrid;
  const bool prepared = system.coarser
                            ? multigrid.prepare(system.A, system.coarser->prolongation, system.coarser->A)
                            : multigrid.prepare(system.A);
  out.seconds_factor += lap(begin);
  if (auto stop = context.stop()) return *stop;
  if (!prepared) return false;
  out.solver = LinearSolver::iterative;
  out.x = Eigen::VectorXd::Zero(system.b.size());
  const Iterations done =
      multigrid.solve(system.b, out.x, {.stop = [&] { return context.stop().has_value(); }});
  if (auto stop = context.stop()) return *stop;
  out.iterations = done.count;
  out.residual = done.residual;
  out.seconds_solve += lap(begin);
  return done.converged;
}

}  // namespace

Result<LinearSolution> solved(const LinearSystem& system, LinearSolver solver, const RunContext& context) {
  LinearSolution out;
  if (system.b.size() == 0) return out;
  if (solver == LinearSolver::automatic)
    solver = system.A.rows() < kMultigridUnknowns ? LinearSolver::direct : LinearSolver::iterative;
  if (solver == LinearSolver::iterative) {
    const Result<bool> done = solve_by_multigrid(system, out, context);
    if (!done) return done.error();
    if (done.value()) return out;
  }
  if (Status s = solve_directly(system, out, context); !s) return s.error();
  return out;
}

}  // namespace overtet::solve_detail
