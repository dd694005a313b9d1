#include "kernels/bvh/bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "kernels/bvh/self_intersections.h"
#include "kernels/predicates/predicates.h"

namespace overtet {
namespace {

constexpr unsigned kSeed = 417;

// A crumpled grid: neighbours, near neighbours and far folds that meet.
Surface crumpled(int n, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-noise, noise);
  Surface s;
  s.V.resize((n + 1) * (n + 1), 3);
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double u = double(i) / n, v = double(j) / n;
      s.V.row(i * (n + 1) + j) << std::cos(9 * u) * (1 + .1 * v), std::sin(9 * u) * (1 + .2 * v), v;
      for (int k = 0; k < 3; ++k) s.V(i * (n + 1) + j, k) += jitter(random);
    }
  s.F.resize(2 * n * n, 3);
  Index f = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Index a = i * (n + 1) + j, b = a + n + 1;
      s.F.row(f++) << a, b, b + 1;
      s.F.row(f++) << a, b + 1, a + 1;
    }
  return s;
}

std::vector<FacePair> brute_force(const Surface& s, const std::vector<std::uint8_t>& active = {}) {
  std::vector<FacePair> out;
  for (Index f = 0; f < s.F.rows(); ++f)
    for (Index g = f + 1; g < s.F.rows(); ++g)
      if ((active.empty() || active[f] || active[g]) &&
          faces_intersect(s.V.data(), s.F.data() + 3 * f, s.F.data() + 3 * g))
        out.emplace_back(f, g);
  return out;
}

TEST(SelfIntersections, EqualBruteForceAfterBuildAndRefit) {
  SCOPED_TRACE(kSeed);
  const Surface start = crumpled(18, 0.0, kSeed);
  TriangleBvh bvh(start.V, start.F);
  for (const double noise : {0.0, 0.02, 0.1, 0.4}) {
    const Surface moved = crumpled(18, noise, kSeed + 1);
    const auto want = brute_force(moved);
    EXPECT_EQ(find_self_intersections(moved.V, moved.F), want);
    bvh.refit(moved.V, moved.F);
    EXPECT_EQ(find_self_intersections(moved.V, moved.F, bvh), want);
    SelfIntersectionOptions first;
    first.stop_at_first = true;
    const auto found = find_self_intersections(moved.V, moved.F, bvh, first);
    EXPECT_EQ(found.empty(), want.empty());
    for (const auto& pair : found) EXPECT_TRUE(std::binary_search(want.begin(), want.end(), pair));
  }
}

TEST(SelfIntersections, OnlyPairsWithAnActiveFace) {
  const Surface s = crumpled(16, 0.15, kSeed + 2);
  SelfIntersectionOptions options;
  options.active.assign(s.F.rows(), 0);
  for (Index f = 0; f < s.F.rows(); f += 7) options.active[f] = 1;
  const auto want = brute_force(s, options.active);
  EXPECT_FALSE(want.empty());
  EXPECT_EQ(find_self_intersections(s.V, s.F, options), want);
}

TEST(SelfIntersections, SameOnAnyNumberOfThreads) {
  const Surface s = crumpled(60, 0.05, kSeed + 3);
  SelfIntersectionOptions first;
  first.stop_at_first = true;
  std::vector<FacePair> all, some;
  for (const int threads : {1, 2, 3, 8}) {
    const ScopedThreads scope(threads);
    const auto pairs = find_self_intersections(s.V, s.F);
    const auto found = find_self_intersections(s.V, s.F, first);
    if (threads == 1) all = pairs, some = found;
    EXPECT_EQ(pairs, all);
    EXPECT_EQ(found, some);
  }
}

TEST(SelfIntersections, ExtremeScalesAndCoincidentFaces) {
  Surface s = crumpled(8, 0.2, kSeed + 4);
  const auto want = brute_force(s);
  for (const int exponent : {-900, -200, 200, 1000}) {
    Surface scaled = s;
    for (Index i = 0; i < scaled.V.size(); ++i) scaled.V.data()[i] = std::ldexp(s.V.data()[i], exponent);
    EXPECT_EQ(find_self_intersections(scaled.V, scaled.F), want);
  }
  s.V.setZero();  // everything at one point: all boxes equal
  EXPECT_EQ(find_self_intersections(s.V, s.F), brute_force(s));
  EXPECT_TRUE(find_self_intersections(VertexMatrix(0, 3), TriangleMatrix(0, 3)).empty());
}

TEST(SelfIntersections, NotFiniteIsSeen) {
  Surface s = crumpled(4, 0, 1);
  EXPECT_TRUE(all_finite(s.V));
  s.V(7, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(all_finite(s.V));
}

// One vertex and a ring around it that is closed, turns `turns` times and goes up and down.
Surface fan(int corners, int turns, double height, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  Surface s;
  s.V.resize(corners + 1, 3);
  s.F.resize(corners, 3);
  s.V.row(corners).setZero();
  for (int i = 0; i < corners; ++i) {
    const double t = 2 * M_PI * turns * (i + 0.8 * unit(random)) / corners, r = 0.3 + unit(random);
    s.V.row(i) << r * std::cos(t), r * std::sin(t), height * (2 * unit(random) - 1);
    s.F.row(i) << corners, i, (i + 1) % corners;
  }
  return s;
}

TEST(SelfIntersections, AroundOneVertexEqualBruteForce) {
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  int clean = 0, crossing = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const int turns = trial % 5 == 0 ? 2 : 1;
    Surface s = fan(3 + trial % 12, turns, 0.3 * (trial % 8), random);
    if (trial % 3 == 0) {  // on a grid: points on the half-lines, coplanar faces
      for (Index i = 0; i < s.V.size(); ++i) s.V.data()[i] = std::round(4 * s.V.data()[i]) / 4;
    }
    if (trial % 7 == 0) s.F.row(0).swap(s.F.row(s.F.rows() - 1));
    if (trial % 11 == 0) std::swap(s.F(1, 0), s.F(1, 1));              // turned over
    if (trial % 13 == 0) s.F.conservativeResize(s.F.rows() - 1, 3);    // open
    if (trial % 17 == 0) s.F.row(s.F.rows() - 1) = s.F.row(0).eval();  // twice the same
    const auto want = brute_force(s);
    ASSERT_EQ(find_self_intersections(s.V, s.F), want) << "trial " << trial;
    ++(want.empty() ? clean : crossing);
  }
  EXPECT_GT(clean, 200);
  EXPECT_GT(crossing, 200);
}

TEST(Bvh, BoxAndRayQueriesMissNothing) {
  const Surface s = crumpled(14, 0.05, kSeed + 7);
  const TriangleBvh bvh(s.V, s.F);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(-1.2, 1.2);
  for (int trial = 0; trial < 300; ++trial) {
    double lo[3], hi[3], o[3], d[3];
    for (int k = 0; k < 3; ++k) {
      lo[k] = u(random);
      hi[k] = lo[k] + 0.2 * std::fabs(u(random));
      o[k] = u(random);
      d[k] = trial % 3 == 0 && k != trial % 2 ? 0 : u(random);
    }
    std::set<Index> in_box, on_ray;
    bvh.query_box(lo, hi, [&](Index f) { in_box.insert(f); });
    bvh.query_ray(o, d, 0, [&](Index f) { on_ray.insert(f); });
    const double far[3] = {o[0] + 20 * d[0], o[1] + 20 * d[1], o[2] + 20 * d[2]};
    for (Index f = 0; f < s.F.rows(); ++f) {
      const double *a = s.V.data() + 3 * s.F(f, 0), *b = s.V.data() + 3 * s.F(f, 1),
                   *c = s.V.data() + 3 * s.F(f, 2);
      bool inside = false;
      for (const double* p : {a, b, c})
        inside = inside || (lo[0] <= p[0] && p[0] <= hi[0] && lo[1] <= p[1] && p[1] <= hi[1] &&
                            lo[2] <= p[2] && p[2] <= hi[2]);
      if (inside) {
        EXPECT_TRUE(in_box.count(f));
      }
      if (segment_triangle_intersect(o, far, a, b, c)) {
        EXPECT_TRUE(on_ray.count(f));
      }
    }
  }
}

}  // namespace
}  // namespace overtet
