#include "kernels/contact/contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "kernels/bvh/self_intersections.h"
#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"
#include "tests/support/flow_surfaces.h"

namespace overtet {
namespace {

using Eigen::Vector3d;
constexpr std::uint32_t kSeed = 1;

Vector3d random_point(std::mt19937& random, double size = 1) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return {uniform(random), uniform(random), uniform(random)};
}

std::array<Vector3d, 4> random_pair(std::mt19937& random, int trial) {
  std::array<Vector3d, 4> x;
  for (auto& p : x) p = random_point(random);
  if (trial % 4 == 1) x[3] = x[2] + 1e-9 * (x[3] - x[2]);  // nearly equal corners
  if (trial % 4 == 2) x[3] = x[1] + 0.3 * (x[2] - x[1]);   // flat triangle
  if (trial % 4 == 3) x[3] = x[2] + (x[1] - x[0]);         // parallel edges
  return x;
}

TEST(Closest, MatchesASearchOverTheParameters) {
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 400; ++trial) {
    const auto x = random_pair(random, trial);
    for (PairKind kind : {PairKind::vertex_triangle, PairKind::edge_edge}) {
      const Closest c = closest_points(kind, x);
      double sum = 0;
      Vector3d difference = Vector3d::Zero();
      for (int i = 0; i < 4; ++i) sum += c.w[i], difference += c.w[i] * x[i];
      EXPECT_NEAR(sum, 0, 1e-14);
      EXPECT_LT((difference - c.difference).norm(), 1e-13);
      EXPECT_NEAR(c.distance, c.difference.norm(), 1e-15);
      // Grid over both parameters: never shorter, and nearly reached.
      double best = 1e300;
      const int n = 60;
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
          const double s = double(i) / n, t = double(j) / n;
          Vector3d d;
          if (kind == PairKind::vertex_triangle) {
            if (i + j > n) continue;
            d = x[0] - ((1 - s - t) * x[1] + s * x[2] + t * x[3]);
          } else {
            d = (1 - s) * x[0] + s * x[1] - (1 - t) * x[2] - t * x[3];
          }
          best = std::min(best, d.norm());
        }
      }
      EXPECT_LE(c.distance, best + 1e-12) << "trial " << trial;
      EXPECT_GE(c.distance, best - 0.1) << "trial " << trial;
    }
  }
}

TEST(Closest, DerivativeAgainstFiniteDifferences) {
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 400; trial += 4) {
    const auto x = random_pair(random, trial);
    std::array<Vector3d, 4> p;
    for (auto& v : p) v = random_point(random);
    for (PairKind kind : {PairKind::vertex_triangle, PairKind::edge_edge}) {
      const Closest c = closest_points(kind, x);
      double slope = 0;
      for (int i = 0; i < 4; ++i) slope += c.w[i] * c.difference.dot(p[i]) / c.distance;
      const double e = 1e-6;
      auto plus = x, minus = x;
      for (int i = 0; i < 4; ++i) plus[i] += e * p[i], minus[i] -= e * p[i];
      const double expected =
          (closest_points(kind, plus).distance - closest_points(kind, minus).distance) / (2 * e);
      EXPECT_NEAR(slope, expected, 1e-4 * (1 + std::abs(expected)));
    }
  }
}

TEST(Barrier, DerivativesAndEnd) {
  for (double x = 0.01; x < 0.999; x += 0.01) {
    const double e = 1e-6;
    EXPECT_NEAR(barrier_slope(x), (barrier(x + e) - barrier(x - e)) / (2 * e),
                1e-5 * (1 + std::abs(barrier_slope(x))));
    EXPECT_NEAR(barrier_curvature(x), (barrier_slope(x + e) - barrier_slope(x - e)) / (2 * e),
                1e-5 * (1 + barrier_curvature(x)));
    EXPECT_LT(barrier_slope(x), 0);
    EXPECT_GT(barrier_curvature(x), 0);
  }
  EXPECT_EQ(barrier(1), 0);
  EXPECT_EQ(barrier_slope(1), 0);
  EXPECT_EQ(barrier_curvature(1), 0);
}

TEST(SafeStep, IsConservativeAndNotTooMuch) {
  std::mt19937 random(kSeed);
  int blocked = 0, too_short = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto x = random_pair(random, trial % 2 == 0 ? 0 : trial);
    std::array<Vector3d, 4> p;
    const Vector3d common = random_point(random, 10);
    for (auto& v : p) v = common + random_point(random, 2);
    for (PairKind kind : {PairKind::vertex_triangle, PairKind::edge_edge}) {
      const double start = closest_points(kind, x).distance;
      const double safe = safe_step(kind, x, p);
      ASSERT_GE(safe, 0);
      ASSERT_LE(safe, 1);
      double smallest = start, first_close = 2;
      for (int i = 0; i <= 400; ++i) {
        const double t = i / 400.0;
        auto y = x;
        for (int k = 0; k < 4; ++k) y[k] += t * p[k];
        const double d = closest_points(kind, y).distance;
        if (t <= safe) smallest = std::min(smallest, d);
        if (d < 0.15 * start) first_close = std::min(first_close, t);
      }
      EXPECT_GE(smallest, 0.099 * start) << "trial " << trial;
      if (safe < 1) ++blocked, too_short += safe < first_close - 0.02;
    }
  }
  EXPECT_GT(blocked, 100);
  EXPECT_LT(too_short, blocked / 20);
}

Eigen::VectorXd constant(const Surface& s, double h) { return Eigen::VectorXd::Constant(s.V.rows(), h); }

TEST(ContactMesh, IntersectionsMatchBruteForce) {
  const Surface s = test::bent_capsule(400, 1, 0.3, 40, 10);
  std::set<IndexPair> expected;
  for (Index f = 0; f < s.F.rows(); ++f)
    for (Index g = f + 1; g < s.F.rows(); ++g)
      if (faces_intersect(s.V.data(), s.F.row(f).data(), s.F.row(g).data())) expected.insert({f, g});
  ASSERT_GT(expected.size(), 10u);
  ContactMesh mesh(s.V, s.F, std::vector<char>(s.V.rows(), 1));
  const auto found = mesh.intersections(s.V);
  EXPECT_EQ(std::set<IndexPair>(found.begin(), found.end()), expected);
  std::set<IndexPair> other;
  for (const auto& [f, g] : find_self_intersections(s.V, s.F)) other.insert({f, g});
  EXPECT_EQ(other, expected);
}

TEST(ContactMesh, ContactsMatchBruteForceFrozenOrNot) {
  const Surface s = test::bent_capsule(345, 1, 0.3, 40, 10);  // ends close to each other
  for (int frozen_part : {0, 2}) {
    std::vector<char> free(s.V.rows(), 1);
    for (std::size_t v = 0; v < free.size(); ++v) free[v] = frozen_part == 0 || v % 200 < 90;
    ContactRule rule;
    rule.reach = 1.0;
    const Eigen::VectorXd h = constant(s, 0.12);
    ContactMesh mesh(s.V, s.F, free, s.V, h, rule);
    std::map<std::array<Index, 4>, double> found;
    for (const Contact& c : mesh.find_contacts(s.V)) {
      auto v = c.v;
      if (c.kind == PairKind::vertex_triangle) {
        std::sort(v.begin() + 1, v.end());
      } else {
        if (v[0] > v[1]) std::swap(v[0], v[1]);
        if (v[2] > v[3]) std::swap(v[2], v[3]);
        if (v[0] > v[2]) v = {v[2], v[3], v[0], v[1]};
      }
      if (c.kind == PairKind::vertex_triangle) v[0] = -1 - v[0];  // told apart from edges
      EXPECT_TRUE(found.emplace(v, c.closest.distance).second) << "listed twice";
    }
    std::set<std::array<Index, 2>> edges;
    std::map<std::array<Index, 4>, double> expected;
    const auto consider = [&](PairKind kind, std::array<Index, 4> v) {
      std::array<Vector3d, 4> x;
      bool any_free = false;
      for (int k = 0; k < 4; ++k) x[k] = s.V.row(v[k]).transpose(), any_free = any_free || free[v[k]];
      if (!any_free) return;
      const int split = kind == PairKind::vertex_triangle ? 1 : 2;
      bool near = false;
      for (int a = 0; a < split; ++a)
        for (int b = split; b < 4; ++b) near = near || mesh.adjacent(v[a], v[b]);
      const double d = closest_points(kind, x).distance;
      const double dhat = near ? std::max(std::min(0.12, 0.5 * d), 0.012) : 0.12;
      if (d >= dhat) return;
      if (kind == PairKind::vertex_triangle) v[0] = -1 - v[0];
      expected[v] = d;
    };
    for (Index f = 0; f < s.F.rows(); ++f) {
      std::array<Index, 3> t = {s.F(f, 0), s.F(f, 1), s.F(f, 2)};
      std::sort(t.begin(), t.end());
      for (int k = 0; k < 3; ++k)
        edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
      for (Index v = 0; v < s.V.rows(); ++v)
        if (v != t[0] && v != t[1] && v != t[2]) consider(PairKind::vertex_triangle, {v, t[0], t[1], t[2]});
    }
    for (const auto& a : edges)
      for (const auto& b : edges)
        if (a < b && a[0] != b[0] && a[0] != b[1] && a[1] != b[0] && a[1] != b[1])
          consider(PairKind::edge_edge, {a[0], a[1], b[0], b[1]});
    ASSERT_GT(expected.size(), 50u);
    EXPECT_EQ(found.size(), expected.size());
    for (const auto& [v, d] : expected) {
      const auto it = found.find(v);
      ASSERT_TRUE(it != found.end());
      EXPECT_NEAR(it->second, d, 1e-12);
    }
  }
}

// What is remembered between calls never changes an answer.
TEST(ContactMesh, RememberedPairsMatchAFreshSearch) {
  const Surface s = test::bent_capsule(321, 1, 0.3, 40, 10);
  ASSERT_TRUE(ContactMesh(s.V, s.F, std::vector<char>(s.V.rows(), 1)).intersections(s.V).empty());
  std::vector<char> free(s.V.rows(), 1);
  for (std::size_t v = 0; v < free.size(); ++v) free[v] = v % 200 < 150;
  const Eigen::VectorXd h = constant(s, 0.12);
  ContactMesh mesh(s.V, s.F, free, s.V, h);
  std::mt19937 random(kSeed);
  const auto sorted = [](std::vector<Contact> list) {
    std::vector<std::tuple<std::array<Index, 4>, double, double>> out;
    for (const Contact& c : list) out.emplace_back(c.v, c.closest.distance, c.dhat);
    std::sort(out.begin(), out.end());
    return out;
  };
  const auto sorted_hits = [](const std::vector<ContactMesh::Hit>& list) {
    std::vector<std::pair<std::array<Index, 4>, double>> out;
    for (const auto& hit : list) out.emplace_back(hit.v, hit.safe);
    std::sort(out.begin(), out.end());
    return out;
  };
  VertexMatrix X = s.V;
  int hits = 0;
  for (int step = 0; step < 40; ++step) {
    VertexMatrix P = VertexMatrix::Zero(X.rows(), 3);
    for (Eigen::Index v = 0; v < P.rows(); ++v)
      if (free[v]) P.row(v) = random_point(random, step % 10 == 9 ? 0.05 : 0.0001 * (step + 1)).transpose();
    const Eigen::VectorXd now = h * (0.2 + 0.02 * step);
    ContactMesh fresh(X, s.F, free, s.V, h);
    mesh.set_mean_edges(now);
    fresh.set_mean_edges(now);
    ASSERT_EQ(sorted(mesh.find_contacts(X)), sorted(fresh.find_contacts(X))) << "step " << step;
    ContactMesh untouched(X, s.F, free, s.V, h);  // has no lists: takes the long way
    const auto found = mesh.check_step(X, P);
    ASSERT_EQ(sorted_hits(found), sorted_hits(untouched.check_step(X, P))) << "step " << step;
    hits += !found.empty();
    if (found.empty()) X += P;
  }
  EXPECT_GT(hits, 0);
  EXPECT_LT(hits, 35);
}

TEST(ContactMesh, NoStepPassesThrough) {
  // One end of the tube is pushed right through the other: the positions before and after are both free
  // of intersections, and only the way between is not.
  const Surface s = test::bent_capsule(330, 1, 0.25, 40, 10);
  ContactMesh mesh(s.V, s.F, std::vector<char>(s.V.rows(), 1), s.V, constant(s, 0.1));
  ASSERT_TRUE(mesh.intersections(s.V).empty());
  VertexMatrix P = VertexMatrix::Zero(s.V.rows(), 3);
  for (Eigen::Index v = 0; v < P.rows(); ++v)
    if (s.V(v, 1) > 0 && s.V(v, 0) > 0.5) P(v, 1) = -5 * s.V(v, 1);
  EXPECT_FALSE(mesh.check_step(s.V, P).empty());
  // A common motion, however long, is safe.
  P.rowwise() = Eigen::RowVector3d(10, -20, 30);
  EXPECT_TRUE(mesh.check_step(s.V, P).empty());
  // Random steps that are called safe stay free of intersections all the way.
  std::mt19937 random(kSeed);
  int safe = 0;
  for (int trial = 0; trial < 60; ++trial) {
    for (Eigen::Index v = 0; v < P.rows(); ++v)
      P.row(v) = random_point(random, 0.002 * (trial + 1)).transpose();
    if (!mesh.check_step(s.V, P).empty()) continue;
    ++safe;
    for (int i = 1; i <= 10; ++i) ASSERT_TRUE(mesh.intersections(s.V + (0.1 * i) * P).empty());
  }
  EXPECT_GT(safe, 2);
  EXPECT_LT(safe, 60);
}

}  // namespace
}  // namespace overtet
