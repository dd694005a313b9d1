#include "src/exact/rays.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "src/exact/piercing.h"
#include "src/exact/wedges.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using exact::det_sign;
using exact::dot_sign;
using exact::Point;
using exact::Rational;
using exact::Vec;
using exact::Whole;

constexpr unsigned kSeed = 20261;

// Fractions of all lengths, often 0 or equal.
Vec random_vec(std::mt19937& random) {
  Vec out;
  for (int k = 0; k < 3; ++k) {
    out[k] = Rational(static_cast<long>(random() % 9) - 4, 1 + random() % 6);
    out[k].canonicalize();
    if (random() % 4 == 0) out[k] *= Rational(std::ldexp(1.0, static_cast<int>(random() % 400) - 200));
  }
  return out;
}

TEST(Exact, SignsInIntegersAreThoseOfFractions) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  int zero = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const Vec a = random_vec(random), b = random_vec(random);
    const Vec c = trial % 3 == 0 ? a + Rational(2) * b : random_vec(random);
    const Whole x = whole(a), y = whole(b), z = whole(c);
    EXPECT_EQ(dot_sign(x, y), exact::sign(dot(a, b)));
    EXPECT_EQ(det_sign(x, y, z), exact::sign(det(a, b, c)));
    EXPECT_EQ(exact::is_zero(exact::cross(x, y)), exact::is_zero(exact::cross(a, b)));
    zero += det_sign(x, y, z) == 0;
  }
  EXPECT_GT(zero, 500);
}

TEST(Exact, OnePrimitiveDirectionForALine) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 1000; ++trial) {
    const Vec a = random_vec(random);
    const Whole p = exact::primitive(a);
    if (exact::is_zero(a)) {
      EXPECT_TRUE(exact::is_zero(p));
      continue;
    }
    EXPECT_TRUE(exact::is_zero(exact::cross(p, whole(a))));
    EXPECT_EQ(p, exact::primitive(Rational(-7, 3) * a));
    const mpz_class divisor = gcd(gcd(p[0], p[1]), p[2]);
    EXPECT_EQ(divisor, 1);
  }
}

TEST(Exact, UnitVectorsOfIntegersOfAnyLength) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 1000; ++trial) {
    Whole a;
    double near[3], length = 0;
    for (int k = 0; k < 3; ++k) {
      const int x = static_cast<int>(random() % 2001) - 1000;
      a[k] = x;
      a[k] <<= trial * 3;  // far out of the range of doubles
      near[k] = x;
      length += near[k] * near[k];
    }
    if (length == 0) continue;
    const auto u = exact::unit(a);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(u[k], near[k] / std::sqrt(length), 1e-15);
  }
}

TEST(Exact, SidesOfPointsInDoublesAreThoseOfFractions) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const Surface s = test::box(3);
  const TriangleBvh bvh(s.V, s.F);
  const exact::Rays rays(s.V, s.F, bvh);
  int on = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Index v = static_cast<Index>(random() % s.V.rows()), f = static_cast<Index>(random() % s.F.rows());
    const Point p(s.V.data() + 3 * v);
    EXPECT_TRUE(p.in_doubles && Point(p.x).in_doubles);
    const Vec n = rays.normal(f), height = p.x - exact::vec(rays.corner(f, 0));
    EXPECT_EQ(rays.side(p, f), exact::sign(dot(n, height)));
    EXPECT_EQ(exact::dot_sign(rays.whole_normal(f), exact::whole(n)), 1);
    EXPECT_TRUE(exact::is_zero(exact::cross(rays.whole_normal(f), exact::whole(n))));
    // A third of it is no double, and lies on the same side of a plane a third as far.
    const Point third(exact::vec(rays.corner(f, 0)) + Rational(1, 3) * height);
    EXPECT_EQ(rays.side(third, f), rays.side(p, f));
    on += rays.side(p, f) == 0;
  }
  EXPECT_GT(on, 100);
}

TEST(Exact, PiercingPointsAreThoseOfFractions) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  // Of similar size, whole, of very different sizes, subnormal.
  const auto number = [&](int kind) {
    const double x = std::uniform_real_distribution<double>(-1, 1)(random);
    return kind == 0   ? x
           : kind == 1 ? std::floor(9 * x)
           : kind == 2 ? std::ldexp(x, static_cast<int>(random() % 2000) - 1000)
                       : std::ldexp(x, -1060);
  };
  int met = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    double point[5][3];
    for (auto& p : point)
      for (double& x : p) x = number(trial % 4);
    const Vec p = exact::vec(point[0]), q = exact::vec(point[1]), a = exact::vec(point[2]);
    const Vec n = exact::cross(exact::vec(point[3]) - a, exact::vec(point[4]) - a);
    if (exact::sign(dot(n, q - p)) == 0) continue;
    ++met;
    const Vec expected = p + Rational(dot(n, a - p) / dot(n, q - p)) * (q - p);
    const Vec found = exact::piercing(point[0], point[1], point[2], point[3], point[4]);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(found[k], expected[k]) << "trial " << trial;
  }
  EXPECT_GT(met, 1000);
}

// Every direction from a point is in one of the wedges around a line through it, and those count what is
// there.
TEST(Wedges, ShowAllWindingNumbersNextToALine) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const Surface box = test::box(2);
  // One in its own place twice, one reversed, one that shares a plane, one that crosses.
  const auto moved = [&](double x, double y, double z) {
    return test::transformed(box, Eigen::Matrix3d::Identity(), {x, y, z});
  };
  for (const Surface& other : {box, test::flipped(box), moved(0.5, 0.25, 0), moved(0.375, 0.25, 0.125)}) {
    const Surface s = test::joined(box, other);
    const TriangleBvh bvh(s.V, s.F);
    const exact::Rays rays(s.V, s.F, bvh);
    const Wedges wedges(rays);
    for (int trial = 0; trial < 40; ++trial) {
      const Index f = static_cast<Index>(random() % s.F.rows());
      const int k = static_cast<int>(random() % 3);
      const Vec a = exact::vec(rays.corner(f, k)), along = exact::vec(rays.corner(f, (k + 1) % 3)) - a;
      const Point m(a + Rational(1 + random() % 30, 31) * along);
      std::set<int> known;
      const Rational step(std::ldexp(1.0, -30));
      for (const Wedge& w : wedges.around(exact::whole(along), m)) {
        EXPECT_EQ(rays.winding(Point(m.x + step * w.direction)), std::optional<int>(w.winding));
        known.insert(w.winding);
      }
      for (int look = 0; look < 60; ++look) {
        double d[3];
        for (double& x : d) x = std::uniform_real_distribution<double>(-1, 1)(random);
        const auto winding = rays.winding(Point(m.x + step * exact::vec(d)));
        if (winding) {
          EXPECT_TRUE(known.count(*winding)) << *winding;
        }
      }
    }
  }
}

}  // namespace
}  // namespace overtet
