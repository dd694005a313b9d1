// Elastic materials: energy density, stress, and its derivative, of a deformation gradient with positive
// determinant.
//
// Given is G = F - I, the gradient of the displacement, so that nothing is lost where it is small. To every
// material a barrier is added that is 0 while J = det F >= kBarrierVolume and infinite at J = 0: none of the
// three has one, and without it the least energy may lie where tets are flipped.
//
//   k (1 - J/J0)^2 (-log(J/J0)), J0 = kBarrierVolume, k = 2 mu + lambda;       the form is that of [Li et al.
//   2020]
#pragma once

#include <Eigen/Core>

#include "overtet/elastic_material.h"

namespace overtet {

struct Lame {
  double mu = 0, lambda = 0;
};
// pre: young > 0, -1 < poisson < 0.5.
Lame lame_of(double young, double poisson);

struct ElasticLaw {
  ElasticMaterial material = ElasticMaterial::neo_hookean;
  Lame lame;
};

// Infinite where J <= 0. 0 at rest.
double energy_density(const ElasticLaw& law, const Eigen::Matrix3d& G);
// Of the same, the first Piola-Kirchhoff stress, its derivative by F; not finite where J <= 0.
Eigen::Matrix3d piola_stress(const ElasticLaw& law, const Eigen::Matrix3d& G);

// `exact`: the second derivative as it is; `definite`: its negative eigenvalues set to 0.
enum class Tangent { exact, definite };

// The second derivative of the energy density, in the frame of F = U diag(sigma) V' [Smith, de Goes, Kim
// 2019], with U and V rotations. dF, turned into D = U' dF V, changes the stress by U T V' with
//   T_ii = sum_j stretch_ij D_jj,    T_ij = same_k D_ij + cross_k D_ji    (i, j, k different).
struct MaterialTangent {
  Eigen::Matrix3d U, V;
  Eigen::Matrix3d stretch;
  Eigen::Vector3d same, cross;

  Eigen::Matrix3d times(const Eigen::Matrix3d& dF) const;  // what dF adds to the stress
};
// pre: J > 0.
MaterialTangent material_tangent(const ElasticLaw& law, const Eigen::Matrix3d& G, Tangent tangent);

// Of Cauchy's stress: the largest shear, weighed after von Mises.
double von_mises_stress(const ElasticLaw& law, const Eigen::Matrix3d& G);

}  // namespace overtet
