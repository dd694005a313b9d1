// Elastic materials: derivatives against finite differences, rotations, and the limit of small strains.
#include "kernels/elastic/material.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "kernels/elastic/flat_time.h"
#include "kernels/elastic/tuning.h"

namespace overtet {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

const ElasticMaterial kAll[] = {ElasticMaterial::st_venant_kirchhoff, ElasticMaterial::corotated,
                                ElasticMaterial::neo_hookean};
constexpr unsigned kSeed = 11;

class Dice {
 public:
  double operator()() { return of_(random_); }
  Matrix3d matrix(double size) {
    return Matrix3d::NullaryExpr([&] { return size * of_(random_); });
  }
  Matrix3d rotation() {
    return Eigen::AngleAxisd(3 * of_(random_), Vector3d(of_(random_), of_(random_), 1.1).normalized())
        .toRotationMatrix();
  }
  // Of positive determinant.
  Matrix3d gradient(double size) {
    for (;;) {
      const Matrix3d G = matrix(size);
      if ((Matrix3d::Identity() + G).determinant() > 0.1) return G;
    }
  }

 private:
  std::mt19937 random_{kSeed};
  std::uniform_real_distribution<double> of_{-1, 1};
};

TEST(Material, StressIsTheDerivativeOfTheEnergyAndTheTangentThatOfTheStress) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  Dice dice;
  for (const ElasticMaterial m : kAll)
    for (int trial = 0; trial < 40; ++trial) {
      const ElasticLaw law{m, lame_of(2, trial % 2 ? 0.3 : 0.0)};
      Matrix3d G = dice.gradient(0.7);
      if (trial % 5 == 0) {  // squeezed until the barrier resists
        const Matrix3d F = Matrix3d::Identity() + G;
        G = F * std::cbrt(kBarrierVolume * (0.3 + 0.08 * trial / 5) / F.determinant()) - Matrix3d::Identity();
      }
      const Matrix3d direction = dice.matrix(1), P = piola_stress(law, G);
      const double h = 1e-5;
      const double slope =
          (energy_density(law, G + h * direction) - energy_density(law, G - h * direction)) / (2 * h);
      EXPECT_NEAR(P.cwiseProduct(direction).sum(), slope, 1e-5 * (1 + P.norm())) << trial;
      const Matrix3d change =
          (piola_stress(law, G + h * direction) - piola_stress(law, G - h * direction)) / (2 * h);
      const MaterialTangent exact = material_tangent(law, G, Tangent::exact);
      EXPECT_LT((exact.times(direction) - change).norm(), 1e-5 * (1 + change.norm())) << trial;
      EXPECT_NEAR(exact.U.determinant(), 1, 1e-12);
      EXPECT_NEAR(exact.V.determinant(), 1, 1e-12);
    }
}

TEST(Material, DefiniteTangentsHaveNoNegativeEigenvalues) {
  Dice dice;
  int differ = 0;
  for (const ElasticMaterial m : kAll)
    for (int trial = 0; trial < 60; ++trial) {
      const ElasticLaw law{m, lame_of(1, 0.4)};
      const Matrix3d G = dice.gradient(0.8);
      const MaterialTangent exact = material_tangent(law, G, Tangent::exact);
      const MaterialTangent definite = material_tangent(law, G, Tangent::definite);
      for (int k = 0; k < 10; ++k) {
        const Matrix3d D = dice.matrix(1);
        const double a = D.cwiseProduct(exact.times(D)).sum(), b = D.cwiseProduct(definite.times(D)).sum();
        EXPECT_GE(b, -1e-12);
        EXPECT_GE(b, a - 1e-9 * (1 + std::abs(a)));
        differ += b > a + 1e-6;
      }
    }
  EXPECT_GT(differ, 100);
}

TEST(Material, RotationsCostNothing) {
  Dice dice;
  for (const ElasticMaterial m : kAll)
    for (int trial = 0; trial < 20; ++trial) {
      const ElasticLaw law{m, lame_of(3, 0.25)};
      const Matrix3d I = Matrix3d::Identity(), R = dice.rotation(), G = dice.gradient(0.6);
      EXPECT_NEAR(energy_density(law, R - I), 0, 1e-14);
      EXPECT_LT(piola_stress(law, R - I).norm(), 1e-13);
      const Matrix3d turned = R * (I + G) - I;
      EXPECT_NEAR(energy_density(law, turned), energy_density(law, G), 1e-12);
      EXPECT_LT((piola_stress(law, turned) - R * piola_stress(law, G)).norm(), 1e-11);
      const Matrix3d other = (I + G) * R - I;  // and so is the material itself
      EXPECT_NEAR(energy_density(law, other), energy_density(law, G), 1e-12);
      EXPECT_NEAR(von_mises_stress(law, turned), von_mises_stress(law, G), 1e-11);
    }
}

// Hooke's law: the error is of the square of the strain.
TEST(Material, AllAgreeWithLinearElasticityWhereStrainsAreSmall) {
  Dice dice;
  for (const ElasticMaterial m : kAll)
    for (int trial = 0; trial < 20; ++trial) {
      const ElasticLaw law{m, lame_of(5, 0.35)};
      const Matrix3d D = dice.matrix(1);
      for (const double size : {1e-3, 1e-6, 1e-9}) {
        const Matrix3d G = size * D, e = (G + G.transpose()) / 2;
        const Matrix3d hooke = 2 * law.lame.mu * e + law.lame.lambda * e.trace() * Matrix3d::Identity();
        // Of rotations some digits of 1 + G are lost.
        const double lost = m == ElasticMaterial::corotated ? 1e-13 : 1e-20;
        EXPECT_LT((piola_stress(law, G) - hooke).norm(), 200 * size * size + lost);
        const double energy = hooke.cwiseProduct(e).sum() / 2;
        EXPECT_NEAR(energy_density(law, G), energy, 200 * size * size * size + lost * size + 1e-30);
      }
    }
}

TEST(Material, WhatIsFlatHasNoEnergyThatCanBePaid) {
  for (const ElasticMaterial m : kAll) {
    const ElasticLaw law{m, lame_of(1, 0.3)};
    double before = 0;
    for (const double J : {0.04, 0.01, 1e-3, 1e-6, 1e-12, 1e-100}) {
      Matrix3d G = Matrix3d::Zero();
      G(2, 2) = J - 1;
      // What is left of it after rounding is 0 or positive.
      const double energy = energy_density(law, G);
      EXPECT_GT(energy, before);
      before = energy;
    }
    Matrix3d G = Matrix3d::Zero();
    G(0, 0) = -1;
    EXPECT_TRUE(std::isinf(energy_density(law, G)));
    G(0, 0) = -2;
    EXPECT_TRUE(std::isinf(energy_density(law, G)));
    EXPECT_TRUE(std::isnan(piola_stress(law, G)(0, 0)));
  }
}

using Corners = Eigen::Matrix<double, 3, 4>;

double volume(const Corners& x) {
  return (x.col(1) - x.col(0)).dot((x.col(2) - x.col(0)).cross(x.col(3) - x.col(0)));
}

TEST(FlatTime, IsBeforeTheFirstRootAndNearIt) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  Dice dice;
  int roots = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Corners x = Corners::NullaryExpr([&] { return dice(); });
    Corners d = Corners::NullaryExpr([&] { return dice(); });
    if (trial % 3 == 0) d *= 1e3;
    const double t = first_flat_time(x, d, 2);
    if (!(volume(x) > 0)) {
      EXPECT_EQ(t, 0);
      continue;
    }
    // By brute force.
    double first = 2;
    const int steps = 20000;
    const double reach = trial % 3 == 0 ? 0.02 : 2;
    for (int i = 1; i <= steps; ++i)
      if (const double at = reach * i / steps; volume(x + at * d) <= 0) {
        first = at;
        break;
      }
    EXPECT_LE(t, first);
    if (first < 2) {
      EXPECT_GE(t, (first - reach / steps) * 0.995) << trial;
      ++roots;
    }
  }
  EXPECT_GT(roots, 300);
}

}  // namespace
}  // namespace overtet
