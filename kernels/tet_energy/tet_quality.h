// How good a tet is: the smallest sine of its six dihedral angles (Klingner and Shewchuk 2008), between
// 0 (flat) and 0.943 (regular). Small for small angles and for angles near 180 degrees, independent of
// scale, and decided together with the exact sign of the volume.
#pragma once

#include <Eigen/Core>
#include <array>

#include "overtet/types.h"

namespace overtet {

// The smallest dihedral sine; 0 when det(b - a, c - a, d - a) is not exactly positive. A tet that is
// exactly positive never gets 0, however thin.
double min_dihedral_sine(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                         const Eigen::Vector3d& d);

// The six sines of a positive tet and the gradients of their logarithms with respect to d.
// Edges in the order ab, bc, ca, ad, bd, cd. pre: no two vertices equal.
struct DihedralSines {
  std::array<double, 6> sine;
  std::array<Eigen::Vector3d, 6> log_gradient;
};
void dihedral_sines(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                    const Eigen::Vector3d& d, DihedralSines& out);

// The six dihedral angles in radians, edges in the order of kTetEdge; accurate for thin tets as well.
std::array<double, 6> dihedral_angles(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                      const Eigen::Vector3d& c, const Eigen::Vector3d& d);

// The solid angle (0 .. 2 pi) at d of the positive tet (a, b, c, d).
double solid_angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d);

// Over the tets of a mesh: each tet counts with its smallest dihedral angle (min, p01, p05, median) and
// its largest (max). Degrees.
struct DihedralStatistics {
  std::int64_t tets = 0;
  double min = 0, p01 = 0, p05 = 0, median = 0, max = 0;
};
DihedralStatistics dihedral_statistics(const VertexMatrix& V, const TetMatrix& T);

}  // namespace overtet
