#include "kernels/predicates/predicates.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/intersections.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

namespace overtet {
namespace {

using Exact = CGAL::Simple_cartesian<CGAL::Exact_rational>;
using Point = std::array<double, 3>;

constexpr unsigned kSeed = 20251122;

Exact::Point_3 exact(const Point& p) { return {p[0], p[1], p[2]}; }

int exact_orient3d(const Point& a, const Point& b, const Point& c, const Point& d) {
  return static_cast<int>(CGAL::orientation(exact(a), exact(b), exact(c), exact(d)));
}

// Points in many regimes: smooth, on a small grid, nearly coplanar, at extreme scales.
class Points {
 public:
  explicit Points(unsigned seed) : random_(seed) {}
  Point smooth() { return {uniform(), uniform(), uniform()}; }
  Point grid(int n) { return {double(integer(n)), double(integer(n)), double(integer(n))}; }
  Point on_plane() {
    const double x = uniform(), y = uniform();
    return {x, y, 0.1 * x + 0.3 * y};
  }
  Point scaled(const Point& p, int exponent) {
    return {std::ldexp(p[0], exponent), std::ldexp(p[1], exponent), std::ldexp(p[2], exponent)};
  }
  Point mixed() {
    Point p = smooth();
    for (double& x : p) x = integer(3) == 0 ? 0 : std::ldexp(x, -integer(600));
    return p;
  }
  int integer(int n) { return static_cast<int>(random_() % n); }

 private:
  double uniform() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  std::mt19937_64 random_;
};

TEST(Orient3d, EqualsExactArithmetic) {
  SCOPED_TRACE(kSeed);
  Points points(kSeed);
  for (int trial = 0; trial < 40000; ++trial) {
    Point p[4];
    const int kind = trial % 7;
    for (auto& x : p) {
      if (kind == 0) x = points.smooth();
      if (kind == 1) x = points.grid(3);
      if (kind == 2) x = points.on_plane();
      if (kind == 3) x = points.mixed();
      if (kind == 4) x = points.scaled(points.on_plane(), 1000);
      if (kind == 5) x = points.scaled(points.on_plane(), -1000);
      if (kind == 6) x = points.scaled(points.on_plane(), -330);
    }
    const int want = exact_orient3d(p[0], p[1], p[2], p[3]);
    ASSERT_EQ(orient3d(p[0].data(), p[1].data(), p[2].data(), p[3].data()), want) << "trial " << trial;
    ASSERT_EQ(orient3d(p[1].data(), p[0].data(), p[2].data(), p[3].data()), -want) << "trial " << trial;
    ASSERT_EQ(orient3d(p[3].data(), p[2].data(), p[1].data(), p[0].data()), want) << "trial " << trial;
    const int flat =
        static_cast<int>(CGAL::orientation(Exact::Point_2(p[0][0], p[0][1]), Exact::Point_2(p[1][0], p[1][1]),
                                           Exact::Point_2(p[2][0], p[2][1])));
    ASSERT_EQ(orient2d(p[0].data(), p[1].data(), p[2].data()), flat) << "trial " << trial;
    ASSERT_EQ(collinear(p[0].data(), p[1].data(), p[2].data()),
              CGAL::collinear(exact(p[0]), exact(p[1]), exact(p[2])));
  }
}

// The common part of two triangles, computed by CGAL in rational numbers.
struct Common {
  bool any = false;
  bool more_than_a_point = false;
  bool area = false;
};
Common common(const Point* a, const Point* b) {
  const Exact::Triangle_3 s(exact(a[0]), exact(a[1]), exact(a[2])), t(exact(b[0]), exact(b[1]), exact(b[2]));
  const auto meet = CGAL::intersection(s, t);
  Common out;
  if (!meet) return out;
  out.any = true;
  out.more_than_a_point = boost::get<Exact::Point_3>(&*meet) == nullptr;
  out.area = out.more_than_a_point && boost::get<Exact::Segment_3>(&*meet) == nullptr;
  return out;
}

TEST(TrianglesIntersect, EqualsCgal) {
  SCOPED_TRACE(kSeed + 1);
  Points points(kSeed + 1);
  int met = 0;
  for (int trial = 0; trial < 12000; ++trial) {
    Point p[6];
    const int kind = trial % 4;
    for (auto& x : p) {
      if (kind == 0) x = points.smooth();
      if (kind == 1) x = points.grid(3);
      if (kind == 2) x = points.grid(4), x[2] = 0;
      if (kind == 3) x = points.on_plane();
    }
    if (collinear(p[0].data(), p[1].data(), p[2].data())) continue;
    if (collinear(p[3].data(), p[4].data(), p[5].data())) continue;
    const Common want = common(p, p + 3);
    met += want.any;
    ASSERT_EQ(
        triangles_intersect(p[0].data(), p[1].data(), p[2].data(), p[3].data(), p[4].data(), p[5].data()),
        want.any)
        << "trial " << trial;
    double V[18];
    for (int i = 0; i < 18; ++i) V[i] = p[i / 3][i % 3];
    const Index f[3] = {0, 1, 2}, g[3] = {3, 4, 5};
    ASSERT_EQ(faces_intersect(V, f, g), want.any);

    // One shared vertex.
    const Index h[3] = {4, 5, 0};
    const Point q[3] = {p[4], p[5], p[0]};
    if (!collinear(q[0].data(), q[1].data(), q[2].data())) {
      const Common at_vertex = common(p, q);
      ASSERT_EQ(faces_intersect(V, f, h), at_vertex.more_than_a_point) << "trial " << trial;
      ASSERT_EQ(faces_intersect(V, h, f), at_vertex.more_than_a_point) << "trial " << trial;
    }
    // A shared edge.
    const Index e[3] = {1, 0, 3};
    const Point r[3] = {p[1], p[0], p[3]};
    if (!collinear(r[0].data(), r[1].data(), r[2].data())) {
      ASSERT_EQ(faces_intersect(V, f, e), common(p, r).area) << "trial " << trial;
      ASSERT_EQ(faces_intersect(V, e, f), common(p, r).area) << "trial " << trial;
    }
  }
  EXPECT_GT(met, 1000);
}

TEST(TrianglesIntersect, FlatTrianglesAreSegments) {
  const Point a{0, 0, 0}, b{4, 0, 0}, c{2, 0, 0};
  const Point u{2, -1, -1}, v{2, 1, -1}, w{2, 0, 3};
  EXPECT_TRUE(triangles_intersect(a.data(), b.data(), c.data(), u.data(), v.data(), w.data()));
  EXPECT_TRUE(triangles_intersect(u.data(), v.data(), w.data(), a.data(), b.data(), c.data()));
  const Point far{5, 0, 0}, farther{6, 0, 0};
  EXPECT_FALSE(triangles_intersect(far.data(), farther.data(), far.data(), u.data(), v.data(), w.data()));
  EXPECT_TRUE(triangles_intersect(a.data(), b.data(), c.data(), c.data(), far.data(), farther.data()));
  EXPECT_FALSE(triangles_intersect(a.data(), b.data(), c.data(), far.data(), far.data(), farther.data()));
}

TEST(TrianglesIntersect, DoesNotDependOnScale) {
  Points points(kSeed + 2);
  for (int trial = 0; trial < 300; ++trial) {
    Point p[6];
    for (auto& x : p) x = trial % 2 ? points.grid(3) : points.on_plane();
    const bool want =
        triangles_intersect(p[0].data(), p[1].data(), p[2].data(), p[3].data(), p[4].data(), p[5].data());
    for (const int exponent : {-900, -400, 400, 1000}) {
      Point q[6];
      for (int i = 0; i < 6; ++i) q[i] = points.scaled(p[i], exponent);
      ASSERT_EQ(
          triangles_intersect(q[0].data(), q[1].data(), q[2].data(), q[3].data(), q[4].data(), q[5].data()),
          want);
    }
  }
}

}  // namespace
}  // namespace overtet
