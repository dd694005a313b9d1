// Convex quadratic programs with bounds: the x that minimises x' Q x / 2 + c' x where 0 <= x <= 1.
//
// An interior point method [Mehrotra 1992] first, whose systems all have the pattern of Q: it needs 20 to 40
// steps whatever the mesh, and bounds its own error. From its solution a primal-dual active set method goes
// on, which is a semismooth Newton method [Hintermueller, Ito, Kunisch 2003]: the unknowns at a bound are
// held there, the others solve a linear system, then those that lie beyond a bound are held and those whose
// multiplier has the wrong sign are set free, all at a time. It ends with the solution to rounding. (Alone,
// from the solution without bounds, it goes round in circles on most meshes, as Q is no M-matrix.) Whether it
// does is seen by the number of unknowns at fault, which must reach a new low now and then [as in Judice and
// Pires 1994].
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kernels/sparse/cholesky.h"
#include "overtet/result.h"
#include "overtet/run_context.h"

namespace overtet::solve_detail {

struct BoundedSolution {
  enum class End {
    exact,    // no unknown is at fault
    gap,      // the interior point method's, with the smallest gap that doubles allow
    stalled,  // the same with a larger gap: steps or digits ran out
  };
  Eigen::VectorXd x;
  double energy = 0;  // x' Q x / 2 + c' x
  // The largest |x - clamp(x - g / diag(Q))|, g = Q x + c: 0 where the conditions of Karush, Kuhn and Tucker
  // hold exactly.
  double residual = 0;
  int interior_steps = 0, active_set_steps = 0;
  End end = End::stalled;
};

class BoundedQp {
 public:
  // Q: positive definite. Errors: limit, interrupted.
  static Result<BoundedQp> prepare(const SymmetricMatrix& Q, const RunContext& context);

  // constant: what the energy has besides; gaps are parts of the sum, which is positive. Different threads
  // may solve at the same time. Errors: unsolved (a system is not positive definite in doubles), limit,
  // interrupted.
  Result<BoundedSolution> solve(const Eigen::VectorXd& c, double constant, const RunContext& context) const;

  double factor_entries() const { return factor_entries_; }

 private:
  SymmetricMatrix Q_;       // rows in the elimination order
  std::vector<int> order_;  // the unknown that each row is
  double factor_entries_ = 0;
};

}  // namespace overtet::solve_detail
