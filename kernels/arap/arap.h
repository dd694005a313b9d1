// As-rigid-as-possible energy of a surface, "spokes and rims" [Chao, Pinkall, Sanan, Schroeder 2010,
// section 4.2], for local-global solvers [Sorkine and Alexa 2007].
//
//   E(U) = 1/2 sum_faces t  sum_corners i of t  sum_edges (j, k) of t
//              c_jk / 3  | (u_j - u_k) - R_i (w_j - w_k) |^2,        c = half cotangents of W,
//
// minimised over the rotations R_i. W is the rest shape. The factor 1/3 makes the quadratic part the
// cotangent Laplacian L of W: grad E(U) = L U - rhs(R) with R the best rotations (their derivative
// drops out, because they are optimal). Cotangents are not clamped: the three edges of one face together
// are positive semi-definite whatever their signs, and clamping them moves the minimum away from W.
//
// A subset of the vertices may be free (see Arap's constructor): then only what they need is evaluated.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "kernels/sparse/cholesky.h"
#include "overtet/types.h"

namespace overtet {

// The rotation R that maximises trace(R S): the best fit of R w to u for S = sum c w u'. A proper
// rotation for every finite S; where it is not unique, one of them (the identity for S = 0).
// Horn's quaternion method, largest root by Newton [Theobald 2005]; SVD where that is ill-conditioned.
Eigen::Matrix3d best_rotation(const Eigen::Matrix3d& S);

class Arap {
 public:
  // F: the faces that count (for a regional solve: those with a free vertex). Rotations are kept for
  // every vertex of these faces. pre: indices below W's rows.
  Arap(const VertexMatrix& W, const TriangleMatrix& F);

  // Local step: the best rotation of every vertex for the positions U. In parallel.
  void fit_rotations(const VertexMatrix& U);

  // G = grad E at U for the current rotations: the full gradient of E where they are the best ones.
  // Rows of vertices that no face uses are zero. In parallel.
  void gradient(const VertexMatrix& U, VertexMatrix& G) const;

  // E at U for the current rotations.
  double energy(const VertexMatrix& U) const;

  // Lower triangle of the quadratic part: the cotangent Laplacian of (W, F).
  const SymmetricMatrix& matrix() const { return L_; }
  const Eigen::Matrix3d& rotation(Index v) const { return rotation_[v]; }

 private:
  TriangleMatrix F_;
  VertexMatrix rest_edges_;  // 3 #F x 3, row 3 f + k: edge opposite to corner k of face f
  VertexMatrix weight_;      // #F x 3
  SymmetricMatrix L_;
  std::vector<Index> used_;                // vertices with a face
  std::vector<Index> star_begin_, star_;   // for used_[i]: star_[star_begin_[i] ..) = 3 f + corner
  std::vector<Eigen::Matrix3d> rotation_;  // by vertex
  std::vector<Eigen::Matrix3d> face_;      // scratch, by face
};

}  // namespace overtet
