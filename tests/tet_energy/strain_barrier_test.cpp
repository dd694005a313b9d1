#include "kernels/tet_energy/strain_barrier.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace overtet {
namespace {

using CornerMatrix = Eigen::Matrix<double, 3, 4>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

constexpr std::uint32_t kStrainSeed = 2013;

double volume_of(const CornerMatrix& x) {
  return (x.col(1) - x.col(0)).dot((x.col(2) - x.col(0)).cross(x.col(3) - x.col(0))) / 6;
}

RestTet at_rest(const CornerMatrix& x) { return rest_tet(x.col(0), x.col(1), x.col(2), x.col(3)); }

CornerMatrix positive_tet(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  CornerMatrix x;
  do {
    for (int i = 0; i < 12; ++i) x.data()[i] = uniform(random);
    if (volume_of(x) < 0) x.col(2).swap(x.col(3));
  } while (volume_of(x) < 0.02);
  return x;
}

TEST(StrainBarrier, IsNothingAtRestWhereverThatIs) {
  std::mt19937 random(kStrainSeed);
  const CornerMatrix x = positive_tet(random);
  const Eigen::Matrix3d R = Eigen::Quaterniond(.3, .1, -.8, .5).normalized().toRotationMatrix();
  CornerMatrix y = R * x;
  y.colwise() += Eigen::Vector3d(3, -1, 2);
  TetEnergy e;
  EXPECT_NEAR(strain_barrier(y, at_rest(x), {2, 3}, Curvature::definite, e), 0, 1e-12);
  EXPECT_LT(e.gradient.norm(), 1e-10);
  EXPECT_NEAR(at_rest(x).volume, volume_of(x), 1e-15);
}

TEST(StrainBarrier, IsInfiniteForFlatAndFlippedTets) {
  std::mt19937 random(kStrainSeed);
  const CornerMatrix x = positive_tet(random);
  CornerMatrix flat = x;
  flat.col(3) = (x.col(0) + x.col(1)) / 2;
  CornerMatrix flipped = x;
  flipped.col(0).swap(flipped.col(1));
  TetEnergy e;
  EXPECT_TRUE(std::isinf(strain_barrier(flat, at_rest(x), {}, Curvature::definite, e)));
  EXPECT_TRUE(std::isinf(strain_barrier(flipped, at_rest(x), {})));
  // And grows towards that.
  double before = 0;
  for (double t = 0.5; t < 0.9999; t += (1 - t) / 2) {
    const double now = strain_barrier((1 - t) * x + t * flat, at_rest(x), {0, 1});
    EXPECT_GT(now, before);
    before = now;
  }
}

TEST(StrainBarrier, DerivativesMatchFiniteDifferences) {
  RecordProperty("seed", static_cast<int>(kStrainSeed));
  std::mt19937 random(kStrainSeed);
  int squeezed = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const CornerMatrix x = positive_tet(random);
    const RestTet rest = at_rest(positive_tet(random));
    const StrainWeights w{trial % 3 == 0 ? 0.0 : 0.7, trial % 3 == 1 ? 0.0 : 0.3};
    squeezed += volume_of(x) < rest.volume;
    TetEnergy e, side;
    const double value = strain_barrier(x, rest, w, Curvature::exact, e);
    ASSERT_NEAR(value, strain_barrier(x, rest, w), 1e-12 * (1 + std::fabs(value)));
    const double h = 1e-5 * std::cbrt(volume_of(x));
    Matrix12 differences;
    for (int k = 0; k < 12; ++k) {
      CornerMatrix y = x;
      y.data()[k] += h;
      const double plus = strain_barrier(y, rest, w, Curvature::exact, side);
      const Eigen::Matrix<double, 12, 1> up = side.gradient;
      y.data()[k] -= 2 * h;
      const double minus = strain_barrier(y, rest, w, Curvature::exact, side);
      EXPECT_NEAR((plus - minus) / (2 * h), e.gradient[k], 1e-5 * (1 + e.gradient.norm())) << trial;
      differences.col(k) = (up - side.gradient) / (2 * h);
    }
    EXPECT_LT((differences - e.hessian).norm(), 1e-4 * (1 + e.hessian.norm())) << trial;
  }
  EXPECT_GT(squeezed, 20);
}

TEST(StrainBarrier, TheDefiniteHessianHasNoNegativeEigenvalueAndIsNoLess) {
  std::mt19937 random(kStrainSeed + 1);
  int indefinite = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const CornerMatrix x = positive_tet(random);
    const RestTet rest = at_rest(positive_tet(random));
    TetEnergy exact, definite;
    strain_barrier(x, rest, {}, Curvature::exact, exact);
    strain_barrier(x, rest, {}, Curvature::definite, definite);
    EXPECT_EQ(exact.gradient, definite.gradient);
    const Eigen::SelfAdjointEigenSolver<Matrix12> a(definite.hessian), b(exact.hessian),
        more(definite.hessian - exact.hessian);
    const double size = definite.hessian.norm();
    EXPECT_GT(a.eigenvalues()[0], -1e-9 * size);
    EXPECT_GT(more.eigenvalues()[0], -1e-9 * size);
    indefinite += b.eigenvalues()[0] < -1e-6 * size;
  }
  EXPECT_GT(indefinite, 20);
}

}  // namespace
}  // namespace overtet
