// One system of equations of second order, solved directly or by multigrid. Internal to src/solve.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "kernels/multigrid/multigrid.h"
#include "overtet/solve.h"

namespace overtet::solve_detail {

// A x = b.
struct LinearSystem {
  SymmetricMatrix A;
  Eigen::VectorXd b;
  // For multigrid: that of linear elements in the same tets, and how their functions are functions of these
  // elements.
  struct Coarser {
    RowMatrix prolongation;
    SymmetricMatrix A;
  };
  std::optional<Coarser> coarser;
};

struct LinearSolution {
  Eigen::VectorXd x;
  LinearSolver solver = LinearSolver::direct;  // not automatic
  int iterations = 0;         // also those that led nowhere, before the direct solver took over
  double residual = 0;        // |b - A x| / |b|
  double factor_entries = 0;  // of the Cholesky factor
  double seconds_factor = 0, seconds_solve = 0;
};

// Errors: unsolved, limit, interrupted.
Result<LinearSolution> solved(const LinearSystem& system, LinearSolver solver, const RunContext& context);

}  // namespace overtet::solve_detail
