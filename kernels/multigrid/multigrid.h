// Systems of scalar elliptic equations: conjugate gradients, preconditioned by algebraic multigrid with
// smoothed aggregation [Vanek, Mandel, Brezina 1996]. Smoothers are Chebyshev polynomials of the fourth kind
// [Lottes 2023] of the matrix over the l1 norms of its rows: no eigenvalue is larger than 1, so that none is
// estimated, and the preconditioner is positive definite. Everything runs on all threads, with the same bytes
// on any number of them.
//
//   Multigrid multigrid;
//   if (!multigrid.prepare(A)) ...                       // not positive definite
//   const auto done = multigrid.solve(b, x, {.tolerance = 1e-12});
//   if (!done.converged) ...
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>

#include "kernels/multigrid/rows.h"
#include "kernels/sparse/cholesky.h"

namespace overtet {

struct IterationOptions {
  double tolerance = 1e-12;  // of |b - A x| / |b|
  // Of the same as the iteration keeps it, without b - A x anew: better than wanted, so that linear functions
  // are found as exactly as by a factor. Two or three iterations more.
  double aim = 1e-14;
  int most_iterations = 200;
  std::function<bool()> stop;  // asked before each iteration
};

struct Iterations {
  // To the tolerance; or to a hundred times as much, where rounding in A x lets nobody come nearer: few
  // values given, so that b is small beside what A x sums up.
  bool converged = false;
  int count = 0;
  double residual = 0;  // |b - A x| / |b|, computed anew at the end; of b = 0: 0
};

class Multigrid {
 public:
  Multigrid();
  ~Multigrid();
  Multigrid(Multigrid&&) noexcept;
  Multigrid& operator=(Multigrid&&) noexcept;

  // False: A is not square and compressed, has a diagonal entry that is not positive or one that is not
  // finite, or its coarsest matrix is not positive definite. A 0 x 0 matrix is fine.
  bool prepare(const SymmetricMatrix& A);
  // With a first coarser level: of `prolongation` (#A x #coarse), where the matrix is `coarse`
  // (prolongation^T A prolongation). For elements of second order: that of the linear ones.
  bool prepare(const SymmetricMatrix& A, RowMatrix prolongation, const SymmetricMatrix& coarse);

  // A x = b. x is the start. pre: prepare() was true.
  Iterations solve(const Eigen::VectorXd& b, Eigen::VectorXd& x, const IterationOptions& options);

  // For reports: entries of the matrices of all levels, and how many levels there are.
  double entries() const;
  int levels() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace overtet
