// The energy of a tet in locally injective mappings [Schueller, Kavan, Panozzo, Sorkine-Hornung 2013]:
// Green's strain relative to a rest state, and a barrier that is infinite where the tet is flat.
//
//   strain / 4 |J'J - I|^2 + barrier phi(det J),      J the linear map from the rest state,
//   phi(x) = 1 / g(x) - 1 for 0 < x < 1, else 0;      g(x) = x^3 - 3 x^2 + 3 x.
//
// phi is 0 with its first two derivatives where the tet has its rest volume, or more.
#pragma once

#include <Eigen/Core>

#include "kernels/tet_energy/tet_energy.h"

namespace overtet {

// A tet at rest. hats: as columns, the gradients of the linear functions that are 1 at a corner and 0 at the
// others.
struct RestTet {
  Eigen::Matrix<double, 3, 4> hats;
  double volume = 0;
};
// Not finite where the tet has no volume.
RestTet rest_tet(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                 const Eigen::Vector3d& d);

struct StrainWeights {
  double strain = 1, barrier = 1;
};

// x: the corners as columns. Infinite where the tet is not positive.
double strain_barrier(const Eigen::Matrix<double, 3, 4>& x, const RestTet& rest,
                      const StrainWeights& weights);

// The same with derivatives (not set where it is infinite). `definite`: the Hessian with its negative
// eigenvalues, as a function of J, set to zero; `exact`: as it is.
enum class Curvature { definite, exact };
double strain_barrier(const Eigen::Matrix<double, 3, 4>& x, const RestTet& rest, const StrainWeights& weights,
                      Curvature curvature, TetEnergy& out);

}  // namespace overtet
