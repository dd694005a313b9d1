// Newton steps on the energy of lim.h, of all vertices of one tet mesh at a time.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "kernels/sparse/cholesky.h"
#include "kernels/tet_energy/strain_barrier.h"
#include "overtet/types.h"

namespace overtet::lim_detail {

// The present state is the rest state until reset() makes another one so.
class Newton {
 public:
  // target: of the first rows of V; must outlive it. unit: the unit of lengths.
  Newton(const TetMesh& mesh, const VertexMatrix& target, double barrier, double unit);

  struct Energies {
    double strain = 0, barrier = 0, distance = 0;  // the last without alpha
    double all(double alpha) const { return strain + barrier + alpha * distance; }
  };
  Energies energies() const { return energies_at(x_); }

  // One step with line search; every tet is positive on the whole straight way (up to rounding) and exactly
  // positive at its end. Returns the part of Newton's step that was made; 0: no descent, nothing changes.
  // False in `ok`: no factor.
  double step(double alpha, bool& ok);

  const VertexMatrix& positions() const { return x_; }

 private:
  Energies energies_at(const VertexMatrix& x) const;
  bool analyze();
  void assemble(double alpha);
  double way(const VertexMatrix& direction) const;  // how far it may go, at most 1
  bool positive_at(const VertexMatrix& x) const;
  StrainWeights weights(std::size_t t) const;
  Eigen::Matrix<double, 3, 4> corners(const VertexMatrix& x, std::size_t t) const;

  const VertexMatrix& target_;
  TetMatrix T_;
  double barrier_, unit_;
  VertexMatrix x_;
  std::vector<RestTet> rest_;
  // In blocks of 3 x 3, lower triangle; of each tet and two of its corners the block's column starts.
  SymmetricMatrix hessian_;
  std::vector<std::array<int, 3>> diagonal_;               // by vertex
  std::vector<std::array<std::array<int, 3>, 6>> blocks_;  // by tet, edges as kTetEdge
  Eigen::VectorXd gradient_;
  SparseCholesky factor_;
  bool analyzed_ = false;
};

}  // namespace overtet::lim_detail
