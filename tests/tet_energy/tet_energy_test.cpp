#include "kernels/tet_energy/tet_energy.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <random>

namespace overtet {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 4>;

Corners random_tet(std::mt19937& random, bool positive) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Corners p;
  for (auto& x : p) x = {uniform(random), uniform(random), uniform(random)};
  const double v = (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0]));
  if ((v > 0) != positive) std::swap(p[2], p[3]);
  return p;
}

TEST(TetEnergy, RegularTetsHaveOne) {
  const double h = std::sqrt(2.0 / 3.0);
  for (const double s : {1e-3, 1.0, 50.0}) {
    const Corners p{Vector3d(0, 0, 0), Vector3d(s, 0, 0), Vector3d(.5 * s, std::sqrt(3.0) / 2 * s, 0),
                    Vector3d(.5 * s, std::sqrt(3.0) / 6 * s, h * s)};
    EXPECT_NEAR(1, shape_energy(p[0], p[1], p[2], p[3], 1, 0), 1e-12);
    EXPECT_NEAR(1, relative_volume(p[0], p[1], p[2], p[3], s), 1e-12);
    EXPECT_TRUE(std::isinf(shape_energy(p[0], p[1], p[3], p[2], 1, 0)));
    EXPECT_TRUE(std::isfinite(shape_energy(p[0], p[1], p[3], p[2], s, 0.1)));
  }
}

TEST(TetEnergy, GradientsMatchFiniteDifferences) {
  std::mt19937 random(17);
  int checked = 0;
  for (int i = 0; i < 200; ++i) {
    const double eps = i % 2 ? 0.2 : 0;
    Corners p = random_tet(random, eps == 0 || i % 4 == 1);
    if (eps == 0 && relative_volume(p[0], p[1], p[2], p[3], 1) < 0.1) continue;
    ++checked;
    TetEnergy e;
    const double value = shape_energy(p[0], p[1], p[2], p[3], 0.8, eps, e);
    EXPECT_NEAR(value, shape_energy(p[0], p[1], p[2], p[3], 0.8, eps), 1e-14 * value);
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>> eigen(e.hessian);
    EXPECT_GT(eigen.eigenvalues()[0], -1e-9 * eigen.eigenvalues()[11]);
    EXPECT_LT((e.hessian - e.hessian.transpose()).norm(), 1e-12 * e.hessian.norm());
    const double h = 1e-6;
    for (int k = 0; k < 12; ++k) {
      Corners q = p;
      q[k / 3][k % 3] += h;
      const double plus = shape_energy(q[0], q[1], q[2], q[3], 0.8, eps);
      q[k / 3][k % 3] -= 2 * h;
      const double minus = shape_energy(q[0], q[1], q[2], q[3], 0.8, eps);
      EXPECT_NEAR((plus - minus) / (2 * h), e.gradient[k], 1e-5 * (1 + e.gradient.norm()));
    }
  }
  EXPECT_GT(checked, 100);
}

TEST(TetEnergy, HessianIsTheTrueOneWhereDetIsLinear) {
  // One corner moves: det is linear in it, so nothing is left out.
  std::mt19937 random(23);
  for (int i = 0; i < 50; ++i) {
    Corners p = random_tet(random, true);
    if (relative_volume(p[0], p[1], p[2], p[3], 1) < 0.2) continue;
    TetEnergy e, plus, minus;
    shape_energy(p[0], p[1], p[2], p[3], 1, 0, e);
    const double h = 1e-6;
    for (int k = 9; k < 12; ++k) {
      Corners q = p;
      q[3][k - 9] += h;
      shape_energy(q[0], q[1], q[2], q[3], 1, 0, plus);
      q[3][k - 9] -= 2 * h;
      shape_energy(q[0], q[1], q[2], q[3], 1, 0, minus);
      for (int l = 9; l < 12; ++l)
        EXPECT_NEAR((plus.gradient[l] - minus.gradient[l]) / (2 * h), e.hessian(k, l),
                    1e-4 * e.hessian.norm());
    }
  }
}

TEST(TetEnergy, DihedralGradientMatchesFiniteDifferences) {
  std::mt19937 random(29);
  for (int i = 0; i < 50; ++i) {
    Corners p = random_tet(random, true);
    if (relative_volume(p[0], p[1], p[2], p[3], 1) < 0.1) continue;
    Eigen::Matrix<double, 12, 1> g;
    dihedral_angle(p[0], p[1], p[2], p[3], &g);
    const double h = 1e-6;
    for (int k = 0; k < 12; ++k) {
      Corners q = p;
      q[k / 3][k % 3] += h;
      const double plus = dihedral_angle(q[0], q[1], q[2], q[3]);
      q[k / 3][k % 3] -= 2 * h;
      const double minus = dihedral_angle(q[0], q[1], q[2], q[3]);
      EXPECT_NEAR((plus - minus) / (2 * h), g[k], 1e-5 * (1 + g.norm()));
    }
  }
}

TEST(TetEnergy, PositiveOnTheWayNeverLies) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int yes = 0, no = 0;
  for (int i = 0; i < 2000; ++i) {
    const Corners p = random_tet(random, true);
    Corners q = p;
    for (auto& x : q) x += 0.5 * Vector3d(uniform(random), uniform(random), uniform(random));
    double least = 1;
    for (int s = 0; s <= 50; ++s) {
      Corners r;
      for (int k = 0; k < 4; ++k) r[k] = p[k] + s / 50.0 * (q[k] - p[k]);
      least = std::min(least, relative_volume(r[0], r[1], r[2], r[3], 1));
    }
    if (positive_on_the_way(p.data(), q.data())) {
      EXPECT_GT(least, 0);
      ++yes;
    } else {
      ++no;
    }
  }
  EXPECT_GT(yes, 500);
  EXPECT_GT(no, 200);
}

}  // namespace
}  // namespace overtet
