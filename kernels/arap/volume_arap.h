// As-rigid-as-possible energy of a tet mesh [Chao, Pinkall, Sanan, Schroeder 2010, section 3], for
// local-global solvers [Sorkine and Alexa 2007].
//
//   E(U) = 1/2 sum_tets t  vol_t | J_t - R_t |^2,      J_t the linear map from the tet of W to that of U,
//
// minimised over the rotations R_t. W is the rest state. grad E(U) = L U - rhs(R) with R the best rotations,
// L the stiffness matrix of linear finite elements on W. The energy of a flipped tet is finite: there is
// always a minimum, and it may have such tets.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "kernels/sparse/cholesky.h"
#include "overtet/types.h"

namespace overtet {

class VolumeArap {
 public:
  // pre: indices below W's rows; every tet has a volume above zero.
  VolumeArap(const VertexMatrix& W, const TetMatrix& T);

  // Local step: the best rotation of every tet for the positions U. In parallel.
  void fit_rotations(const VertexMatrix& U);

  // G = grad E at U for the current rotations: the full gradient of E where they are the best ones. In
  // parallel; the same bytes on any number of threads.
  void gradient(const VertexMatrix& U, VertexMatrix& G) const;

  // E at U for the current rotations.
  double energy(const VertexMatrix& U) const;

  // Lower triangle of L.
  const SymmetricMatrix& matrix() const { return L_; }
  const Eigen::Matrix3d& rotation(Index t) const { return rotation_[t]; }

 private:
  Eigen::Matrix3d jacobian(const VertexMatrix& U, Eigen::Index t) const;

  TetMatrix T_;
  std::vector<double> volume_;
  // Of each tet, as columns: the gradients of the linear functions that are 1 at a corner and 0 at the
  // others.
  std::vector<Eigen::Matrix<double, 3, 4>> hats_;
  SymmetricMatrix L_;
  std::vector<Index> star_begin_, star_;  // of vertex v: star_[star_begin_[v] ..) = 4 t + corner
  std::vector<Eigen::Matrix3d> rotation_;
};

}  // namespace overtet
