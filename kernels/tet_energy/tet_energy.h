// Energies of tets that the volume map minimises, with gradients and positive semidefinite Hessians.
//
// Shape energy: |J|^2 / (3 det(J)^(2/3)), J the linear map from the regular tet; 1 for a regular tet of any
// size, infinite for a flat one. Regularised after Garanzha, Kaporin, Kudryavtseva, Protais, Ray and
// Sokolov, "Foldover-free maps in 50 lines of code" (2021): det is replaced by
// chi = (det + sqrt(eps^2 + det^2)) / 2, which is positive for inverted tets too.
#pragma once

#include <Eigen/Core>

namespace overtet {

struct TetEnergy {
  double value = 0;
  Eigen::Matrix<double, 12, 1> gradient;  // a, b, c, d
  Eigen::Matrix<double, 12, 12> hessian;  // positive semidefinite: the part of the true one that stays
                                          // when the second derivative of det is left out
};

// size: the edge length that gives det(J) = 1; matters for eps > 0 only. With eps = 0 the tet must be
// positive, else the value is infinite and the derivatives are not set.
double shape_energy(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                    const Eigen::Vector3d& d, double size, double eps);
double shape_energy(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                    const Eigen::Vector3d& d, double size, double eps, TetEnergy& out);

// det(J) for the regular reference tet of edge length `size`.
double relative_volume(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                       const Eigen::Vector3d& d, double size);

// The dihedral angle of a positive tet at its edge a-b, and its gradient (a, b, c, d).
double dihedral_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                      const Eigen::Vector3d& d, Eigen::Matrix<double, 12, 1>* gradient = nullptr);

// True when the tet is positive on the whole way from its old corners to its new ones, all moving straight
// and together (volume is a cubic on the way; its four Bernstein coefficients are positive). May say
// false for a way that is fine, never true for one that is not, up to rounding.
bool positive_on_the_way(const Eigen::Vector3d* from, const Eigen::Vector3d* to);

}  // namespace overtet
