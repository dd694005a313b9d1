// Directions in which a potential falls: Newton's, and those of L-BFGS. Internal to src/solve.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "kernels/sparse/cholesky.h"
#include "overtet/elastic.h"
#include "src/solve/elastic_potential.h"

namespace overtet::solve_detail {

class ElasticDirections {
 public:
  virtual ~ElasticDirections() = default;

  // Where the free vertices should go from x, whose gradient is g, if the held ones go the way `given` (0 for
  // the others; empty: nowhere): #V x 3, `given` included. Errors: unsolved (no factor), limit, interrupted.
  virtual Result<VertexMatrix> direction(const ElasticPotential& E, const VertexMatrix& x,
                                         const VertexMatrix& g, const VertexMatrix& given,
                                         const RunContext& context) = 0;
  // What became of it: the part of the way that was gone, and the gradient there.
  virtual void gone(double part, const VertexMatrix& way, const VertexMatrix& g_change) = 0;
  // Another potential.
  virtual void begin() = 0;
  // The last direction was no good: from now on more careful ones. False: there are none.
  virtual bool be_careful() = 0;

  int factorisations = 0;  // so far
};

// number: as ElasticBody has it.
std::unique_ptr<ElasticDirections> newton_directions(const std::vector<Index>& number);
// stiffness: of Laplace's equation, of all vertices, times what the material's is at rest.
std::unique_ptr<ElasticDirections> quasi_newton_directions(const std::vector<Index>& number,
                                                           SymmetricMatrix stiffness);

}  // namespace overtet::solve_detail
