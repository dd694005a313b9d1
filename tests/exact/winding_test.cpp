#include "src/exact/winding.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/support/models.h"

namespace overtet {
namespace {

constexpr unsigned kWindingSeed = 20130;

// The sum of solid angles, in doubles.
double solid_angle_winding(const Surface& s, const Eigen::Vector3d& p) {
  double sum = 0;
  for (Index f = 0; f < s.F.rows(); ++f) {
    const Eigen::Vector3d a = s.V.row(s.F(f, 0)).transpose() - p, b = s.V.row(s.F(f, 1)).transpose() - p,
                          c = s.V.row(s.F(f, 2)).transpose() - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * std::acos(-1.0));
}

TEST(Winding, EqualsTheSumOfSolidAngles) {
  SCOPED_TRACE(kWindingSeed);
  std::mt19937 random(kWindingSeed);
  int not_zero = 0, above_one = 0;
  for (const Surface& s : {test::curled_worm(), test::two_spheres(), test::saucer(), test::elbow(),
                           test::sphere_with_cavity(), test::flipped(test::torus())}) {
    const WindingNumber winding(s);
    const Eigen::RowVector3d lo = s.V.colwise().minCoeff(), hi = s.V.colwise().maxCoeff();
    for (int trial = 0; trial < 250; ++trial) {
      Eigen::Vector3d p;
      for (int k = 0; k < 3; ++k) p[k] = std::uniform_real_distribution<double>(lo[k], hi[k])(random);
      const double want = solid_angle_winding(s, p);
      const auto got = winding.at(p.data());
      ASSERT_TRUE(got.has_value());
      EXPECT_NEAR(*got, want, 1e-6);
      not_zero += *got != 0;
      above_one += *got > 1;
    }
  }
  EXPECT_GT(not_zero, 100);
  EXPECT_GT(above_one, 10);
}

TEST(Winding, PointsInLineWithVerticesAndEdges) {
  // A cube of unit squares seen from lattice points: every axis-parallel ray would graze.
  Surface s = test::box(4);
  s.V *= 8;
  const WindingNumber winding(s);
  const Eigen::RowVector3d lo = s.V.colwise().minCoeff();
  for (int x = -1; x <= 9; ++x)
    for (int y = -1; y <= 9; ++y)
      for (int z = -1; z <= 9; ++z) {
        const double p[3] = {lo[0] + x, lo[1] + y, lo[2] + z};
        const bool outside = x < 0 || x > 8 || y < 0 || y > 8 || z < 0 || z > 8;
        const bool inside = x > 0 && x < 8 && y > 0 && y < 8 && z > 0 && z < 8;
        const auto got = winding.at(p);
        if (outside)
          EXPECT_EQ(got, std::optional<int>(0));
        else if (inside)
          EXPECT_EQ(got, std::optional<int>(1));
        else
          EXPECT_EQ(got, std::nullopt) << "on the surface";
      }
}

TEST(Winding, FractionsAreExact) {
  const Surface s = test::box(2);
  const WindingNumber winding(s);
  const Eigen::RowVector3d lo = s.V.colwise().minCoeff(), hi = s.V.colwise().maxCoeff();
  ASSERT_EQ(hi[0] - lo[0], 1.0);
  // A hair inside and outside of the side at lo[0]: no double lies there.
  const auto at = [&](const std::string& x) { return winding.at({x, "1/3", "1/3"}); };
  Surface moved = s;
  moved.V.rowwise() -= lo;
  const WindingNumber unit(moved);
  const std::string tiny = "1/" + std::string("1") + std::string(400, '0');
  EXPECT_EQ(unit.at({tiny, "1/3", "1/3"}), std::optional<int>(1));
  EXPECT_EQ(unit.at({"-" + tiny, "1/3", "1/3"}), std::optional<int>(0));
  EXPECT_EQ(unit.at({"0", "1/3", "1/3"}), std::nullopt);
  EXPECT_EQ(unit.at({"3/4", "1/3", "1/7"}), std::optional<int>(1));
  for (const char* bad : {"", "-", "1/0", "x", "1/-2", "0.5", "1/", "/2", "1 2"})
    EXPECT_EQ(at(bad), std::nullopt) << bad;
}

TEST(Winding, DoesNotDependOnScale) {
  SCOPED_TRACE(kWindingSeed + 1);
  std::mt19937 random(kWindingSeed + 1);
  const Surface s = test::two_spheres(1);
  const WindingNumber winding(s);
  for (const int exponent : {-900, -250, 320, 900}) {
    Surface scaled = s;
    for (Index i = 0; i < scaled.V.size(); ++i) scaled.V.data()[i] = std::ldexp(s.V.data()[i], exponent);
    const WindingNumber other(scaled);
    for (int trial = 0; trial < 15; ++trial) {
      double p[3], q[3];
      for (int k = 0; k < 3; ++k) {
        p[k] = std::uniform_real_distribution<double>(-1.5, 1.5)(random);
        q[k] = std::ldexp(p[k], exponent);
      }
      EXPECT_EQ(winding.at(p), other.at(q)) << "2^" << exponent;
    }
  }
}

}  // namespace
}  // namespace overtet
