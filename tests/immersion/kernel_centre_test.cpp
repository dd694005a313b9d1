#include "src/immersion/kernel_centre.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "kernels/predicates/predicates.h"

namespace overtet {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

bool sees_all(const std::vector<Wall>& walls, const Vector3d& x) {
  return std::all_of(walls.begin(), walls.end(), [&](const Wall& w) {
    return orient3d(w[0].data(), w[1].data(), w[2].data(), x.data()) > 0;
  });
}

// The walls of a tet, seen from inside.
std::vector<Wall> tet_walls(std::array<Vector3d, 4> p) {
  if (orient3d(p[0].data(), p[1].data(), p[2].data(), p[3].data()) < 0) std::swap(p[0], p[1]);
  return {{p[0], p[1], p[2]}, {p[1], p[0], p[3]}, {p[2], p[1], p[3]}, {p[0], p[2], p[3]}};
}

class KernelCentre : public testing::Test {
 protected:
  std::mt19937 random{20131};
  Vector3d point() {
    std::uniform_real_distribution<double> x(-1, 1);
    return {x(random), x(random), x(random)};
  }
};

// Of a tet the product of the distances is largest at the centroid, whatever its shape.
TEST_F(KernelCentre, OfATetIsTheCentroid) {
  for (const double flat : {1.0, 1e-3, 1e-6, 1e-9}) {
    SCOPED_TRACE(flat);
    for (int i = 0; i < 50; ++i) {
      const Matrix3d turn = Eigen::AngleAxisd(3 * point()[0], point().normalized()).toRotationMatrix();
      std::array<Vector3d, 4> p;
      for (Vector3d& x : p) x = turn * Vector3d(1, 1, flat).asDiagonal() * point();
      const std::vector<Wall> walls = tet_walls(p);
      const Vector3d centroid = (p[0] + p[1] + p[2] + p[3]) / 4;
      if (!sees_all(walls, centroid)) continue;  // flatter than doubles can tell
      const auto way = kernel_centre(walls, p[0]);
      ASSERT_TRUE(way);
      EXPECT_TRUE(sees_all(walls, p[0] + *way));
      // In the tet's own coordinates, in which it is not flat.
      Matrix3d axes;
      axes << p[1] - p[0], p[2] - p[0], p[3] - p[0];
      const Vector3d at = axes.fullPivLu().solve(*way);
      EXPECT_NEAR((at - Vector3d::Constant(0.25)).norm(), 0, 0.05);
    }
  }
}

// As the points of crossings are: on one of the walls, or a little behind it.
TEST_F(KernelCentre, IsFoundFromOutside) {
  for (int i = 0; i < 100; ++i) {
    std::array<Vector3d, 4> p;
    for (Vector3d& x : p) x = point();
    const std::vector<Wall> walls = tet_walls(p);
    const Vector3d start = (p[0] + p[1] + p[2]) / 3 + 0.01 * (p[0] + p[1] + p[2] - 3 * p[3]);
    const auto way = kernel_centre(walls, start);
    ASSERT_TRUE(way);
    EXPECT_TRUE(sees_all(walls, start + *way));
  }
}

TEST_F(KernelCentre, IsNoneWhereNothingIsOpen) {
  for (int i = 0; i < 100; ++i) {
    std::array<Vector3d, 4> p;
    for (Vector3d& x : p) x = point();
    std::vector<Wall> walls = tet_walls(p);
    // A wall in the middle, seen from both sides.
    const Vector3d a = (p[0] + p[3]) / 2, b = (p[1] + p[3]) / 2, c = (p[2] + p[3]) / 2;
    walls.push_back({a, b, c});
    walls.push_back({b, a, c});
    EXPECT_FALSE(kernel_centre(walls, p[0]));
  }
  EXPECT_FALSE(kernel_centre({{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()}}, Vector3d::Zero()));
}

}  // namespace
}  // namespace overtet
