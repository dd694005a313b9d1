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
    bvh.refit(moved.V);
    EXPECT_EQ(find_self_intersections(moved.V, moved.F, bvh), want);
    SelfIntersectionOptions first;
    first.stop_at_first = true;
    const auto found = find_self_intersections(moved.V, moved.F, bvh, first);
    EXPECT_EQ(found.empty(), want.empty());
    for (const auto& pair : found) EXPECT_TRUE(std::binary_search(want.begin(), want.end(), pair));
    EXPECT_EQ(still_intersecting(moved.V, moved.F, want), want);
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

double distance_bound(const Surface& s, Index f, Index g) {  // of the boxes, in the largest coordinate
  double d = 0;
  for (int k = 0; k < 3; ++k) {
    double lo[2], hi[2];
    const Index face[2] = {f, g};
    for (int i = 0; i < 2; ++i) {
      lo[i] = hi[i] = s.V(s.F(face[i], 0), k);
      for (int c = 1; c < 3; ++c) {
        lo[i] = std::min(lo[i], s.V(s.F(face[i], c), k));
        hi[i] = std::max(hi[i], s.V(s.F(face[i], c), k));
      }
    }
    d = std::max(d, std::max(lo[0] - hi[1], lo[1] - hi[0]));
  }
  return d;
}

TEST(Bvh, PaddedPairsAreAllPairsCloserThanThePads) {
  const Surface s = crumpled(14, 0.05, kSeed + 5);
  std::vector<double> pad(s.F.rows());
  for (Index f = 0; f < s.F.rows(); ++f) pad[f] = 0.001 * (f % 50);
  TriangleBvh bvh(s.V, s.F);
  bvh.refit(s.V, pad.data());
  const auto pairs = bvh.collect_self_pairs<FacePair>(
      [](Index f, Index g, std::vector<FacePair>& out) { out.emplace_back(f, g); });
  const std::set<FacePair> found(pairs.begin(), pairs.end());
  EXPECT_EQ(found.size(), pairs.size()) << "a pair was reported twice";
  for (Index f = 0; f < s.F.rows(); ++f)
    for (Index g = f + 1; g < s.F.rows(); ++g) {
      const double gap = distance_bound(s, f, g) - pad[f] - pad[g];
      if (gap <= 0) {
        EXPECT_TRUE(found.count({f, g}));
      }
      if (gap > 1e-5) {
        EXPECT_FALSE(found.count({f, g}));
      }
    }
}

TEST(Bvh, SweptBoxesHoldBothEnds) {
  const Surface a = crumpled(10, 0.0, 1), b = crumpled(10, 0.3, kSeed + 6);
  TriangleBvh bvh(a.V, a.F);
  bvh.refit_swept(a.V, b.V);
  const auto pairs = bvh.collect_self_pairs<FacePair>(
      [](Index f, Index g, std::vector<FacePair>& out) { out.emplace_back(f, g); });
  const std::set<FacePair> found(pairs.begin(), pairs.end());
  for (const auto& pair : brute_force(a)) EXPECT_TRUE(found.count(pair));
  for (const auto& pair : brute_force(b)) EXPECT_TRUE(found.count(pair));
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
