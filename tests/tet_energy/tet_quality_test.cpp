#include "kernels/tet_energy/tet_quality.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

using Eigen::Vector3d;

struct Random {
  explicit Random(unsigned seed) : engine(seed) {}
  std::mt19937 engine;
  double operator()() { return std::uniform_real_distribution<double>(-1, 1)(engine); }
  Vector3d point() { return {(*this)(), (*this)(), (*this)()}; }
};

// The angle between the half planes from edge pq towards r and s, the textbook way.
double angle_at(const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& s) {
  const Vector3d e = (q - p).normalized();
  const Vector3d u = (r - p) - e * e.dot(r - p), w = (s - p) - e * e.dot(s - p);
  return std::acos(std::clamp(u.dot(w) / (u.norm() * w.norm()), -1.0, 1.0));
}

TEST(TetQuality, AnglesAndSinesMatchTheTextbook) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    Vector3d p[4] = {random.point(), random.point(), random.point(), random.point()};
    if ((p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0])) < 0) std::swap(p[2], p[3]);
    const double want[6] = {angle_at(p[0], p[1], p[2], p[3]), angle_at(p[1], p[2], p[0], p[3]),
                            angle_at(p[2], p[0], p[1], p[3]), angle_at(p[0], p[3], p[1], p[2]),
                            angle_at(p[1], p[3], p[0], p[2]), angle_at(p[2], p[3], p[0], p[1])};
    const auto got = dihedral_angles(p[0], p[1], p[2], p[3]);
    DihedralSines sines;
    dihedral_sines(p[0], p[1], p[2], p[3], sines);
    const int place[6] = {0, 3, 1, 2, 4, 5};  // of ab, bc, ca, ad, bd, cd in kTetEdge
    double least = 1;
    for (int e = 0; e < 6; ++e) {
      EXPECT_NEAR(want[e], got[place[e]], 1e-6);
      EXPECT_NEAR(std::sin(want[e]), sines.sine[e], 1e-6);
      least = std::min(least, sines.sine[e]);
    }
    EXPECT_NEAR(least, min_dihedral_sine(p[0], p[1], p[2], p[3]), 1e-9);
    EXPECT_EQ(0, min_dihedral_sine(p[0], p[1], p[3], p[2]));
    EXPECT_EQ(0, min_dihedral_sine(p[0], p[1], p[2], p[2]));
  }
}

TEST(TetQuality, LogGradientsMatchFiniteDifferences) {
  Random random(11);
  for (int i = 0; i < 100; ++i) {
    Vector3d p[4] = {random.point(), random.point(), random.point(), random.point()};
    if ((p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0])) < 0) std::swap(p[1], p[2]);
    DihedralSines at, plus, minus;
    dihedral_sines(p[0], p[1], p[2], p[3], at);
    if (*std::min_element(at.sine.begin(), at.sine.end()) < 0.05) continue;
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vector3d step = Vector3d::Unit(k) * h;
      dihedral_sines(p[0], p[1], p[2], p[3] + step, plus);
      dihedral_sines(p[0], p[1], p[2], p[3] - step, minus);
      for (int e = 0; e < 6; ++e)
        EXPECT_NEAR((std::log(plus.sine[e]) - std::log(minus.sine[e])) / (2 * h), at.log_gradient[e][k],
                    1e-5 * (1 + at.log_gradient[e].norm()));
    }
  }
}

TEST(TetQuality, ThinTetsKeepTheirSign) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  for (const double h : {1e-3, 1e-9, 1e-15, 1e-40, 1e-300}) {
    EXPECT_GT(min_dihedral_sine(a, b, c, {.3, .3, h}), 0);
    EXPECT_EQ(0, min_dihedral_sine(a, b, c, {.3, .3, -h}));
    if (h > 1e-20) {
      EXPECT_NEAR(min_dihedral_sine(a, b, c, {.3, .3, h}) / h, 2.3570226, 1) << h;
    }
  }
  EXPECT_EQ(0, min_dihedral_sine(a, b, c, {.3, .3, 0}));
}

TEST(TetQuality, SolidAnglesAroundAPointAddUp) {
  const Surface s = test::sphere_surface(2);
  Random random(3);
  for (int i = 0; i < 5; ++i) {
    const Vector3d x = random.point() * 0.5;
    double sum = 0;
    for (Eigen::Index f = 0; f < s.F.rows(); ++f)
      sum += solid_angle(s.V.row(s.F(f, 0)), s.V.row(s.F(f, 1)), s.V.row(s.F(f, 2)), x);
    EXPECT_NEAR(4 * M_PI, sum, 1e-9);
  }
}

TEST(TetQuality, StatisticsOfAKuhnGrid) {
  const TetMesh mesh = test::grid_tets(3, 0, 1);
  const auto s = dihedral_statistics(mesh.V, mesh.T);
  EXPECT_EQ(162, s.tets);
  EXPECT_NEAR(45, s.min, 1e-9);
  EXPECT_NEAR(45, s.median, 1e-9);
  EXPECT_NEAR(90, s.max, 1e-9);
}

}  // namespace
}  // namespace overtet
