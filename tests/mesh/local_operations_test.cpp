#include "src/mesh/local_operations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "kernels/tet_energy/tet_quality.h"
#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

double worst_tet(const TetComplex& c) {
  double q = 1;
  for (Index t = 0; t < c.tet_capacity(); ++t) {
    if (!c.alive(t)) continue;
    const auto& v = c.tet(t);
    q = std::min(q,
                 min_dihedral_sine(c.position(v[0]), c.position(v[1]), c.position(v[2]), c.position(v[3])));
  }
  return q;
}

Index random_tet(const TetComplex& c, std::mt19937& random) {
  for (;;)
    if (const Index t = static_cast<Index>(random() % c.tet_capacity()); c.alive(t)) return t;
}

// All operations at random places of a mesh that passes through itself: it stays what it must be, and
// its boundary stays the same.
TEST(LocalOperations, RandomOperationsKeepEverything) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    const TetMesh mesh = test::bent_grid(4, 500, 0.2, seed);
    TetComplex c(mesh.V, mesh.T);
    test::expect_valid(c);
    ASSERT_FALSE(HasFatalFailure());
    const auto boundary = test::boundary_faces(c);
    LocalOperations work(c);
    std::array<int, 13> done{};
    for (int step = 0; step < 6000; ++step) {
      const Index t = random_tet(c, random);
      const auto v = c.tet(t);
      const int i = static_cast<int>(random() % 4), j = static_cast<int>((i + 1 + random() % 3) % 4);
      const auto p = [&](int k) { return c.position(v[k]); };
      const double s = 0.2 + 0.6 * uniform(random);
      bool ok = false;
      const int kind = static_cast<int>(random() % 13);
      const double before = step % 16 == 0 ? worst_tet(c) : 0;
      switch (kind) {
        case 0:
          ok = uniform(random) < 0.2 && work.split_edge(v[i], v[j], (1 - s) * p(i) + s * p(j));
          break;
        case 1:
          ok = uniform(random) < 0.2 &&
               work.split_face(t, i, (p((i + 1) % 4) + p((i + 2) % 4) + p((i + 3) % 4)) / 3);
          break;
        case 2:
          ok = uniform(random) < 0.2 && work.split_tet(t, (p(0) + p(1) + p(2) + p(3)) / 4);
          break;
        case 3:
          ok = work.flip_23(t, i);
          break;
        case 4:
          ok = work.remove_edge(t, v[i], v[j]);
          break;
        case 5:
          ok = work.collapse(v[i], v[j], uniform(random) < 0.5 ? 0 : 1e9);
          break;
        case 6:
          ok = work.insert_at_edge(t, v[i], v[j]);
          break;
        case 7:
          ok = uniform(random) < 0.5 ? work.insert_at_tet(t) : work.smooth(v[i]);
          break;
        case 8:
          ok = work.move_towards(v[i], p(j));
          break;
        case 9:
          ok = work.reconnect(t);
          break;
        case 10:
          ok = work.remove_vertex(v[i], uniform(random) < 0.2 ? 0 : 1e9);
          break;
        case 11:
          ok = work.rebuild_star(v[i], {v[i], v[j], v[(j + 1) % 4 == i ? (j + 2) % 4 : (j + 1) % 4]},
                                 p(i) + 0.1 * (p(j) - p(i)), uniform(random) < 0.2 ? 0 : 1e9);
          break;
        case 12:
          ok = uniform(random) < 0.5 ? work.insert_around(t)
                                     : work.insert_near(t, (p(0) + p(1) + p(2) + p(3)) / 4);
          break;
      }
      done[kind] += ok;
      if (ok && kind > 2 && kind != 5 && kind != 10 && kind != 11 && step % 16 == 0) {
        ASSERT_GE(worst_tet(c), before) << "operation " << kind;
      }
      if (step % 500 == 499) {
        test::expect_valid(c);
        ASSERT_FALSE(HasFatalFailure()) << "after step " << step;
        ASSERT_EQ(boundary, test::boundary_faces(c));
      }
    }
    for (int kind = 0; kind < 13; ++kind) EXPECT_GT(done[kind], 0) << "operation " << kind;
    for (Index v = 0; v < static_cast<Index>(mesh.V.rows()); ++v)
      if (work.fixed(v)) {
        EXPECT_EQ(Eigen::Vector3d(mesh.V.row(v)), c.position(v));
      }
    for (Index t = 0; t < c.tet_capacity(); ++t)
      if (c.alive(t)) {
        const auto& v = c.tet(t);
        ASSERT_EQ(work.quality(t),
                  min_dihedral_sine(c.position(v[0]), c.position(v[1]), c.position(v[2]), c.position(v[3])));
      }
  }
}

// Boundary vertices that may go on inside a ball.
TEST(LocalOperations, SmoothWithinStaysInTheBallAndMakesTheStarBetter) {
  const TetMesh mesh = test::bent_grid(4, 500, 0.2, 3);
  TetComplex c(mesh.V, mesh.T);
  LocalOperations work(c);
  std::vector<Index> star;
  const auto worst = [&](Index v) {
    c.star(v, star);
    double q = 1;
    for (const Index t : star) q = std::min(q, work.quality(t));
    return q;
  };
  int moved = 0, at_the_rim = 0;
  for (Index v = 0; v < c.vertex_count(); ++v) {
    const Eigen::Vector3d centre = c.position(v);
    const double before = worst(v), radius = v % 2 ? 0.02 : 10;
    if (!work.smooth_within(v, centre, radius)) {
      EXPECT_EQ(c.position(v), centre);
      continue;
    }
    EXPECT_GT(worst(v), before);
    const double far = (c.position(v) - centre).norm();
    EXPECT_LE(far, radius);
    ++moved;
    at_the_rim += work.fixed(v) && far > 0.99 * radius;
  }
  EXPECT_GT(moved, 10);
  EXPECT_GT(at_the_rim, 0);
  test::expect_valid(c);
}

// Moves, contractions and insertions that make fewer tets bad: what they promise, at random places.
TEST(LocalOperations, PricesFallAndNoTetFallsTooFar) {
  std::array<int, 3> done{};
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const TetMesh mesh = test::bent_grid(4, 500, 0.2, seed);
    TetComplex c(mesh.V, mesh.T);
    const auto boundary = test::boundary_faces(c);
    LocalOperations work(c);
    LocalOperations::Price price{.goal = 0.3, .low = 0.15};
    // Pairs of a sum and how many tets are below `low`.
    const auto rated = [&] {
      std::pair<double, int> sum{0, 0};
      for (Index t = 0; t < c.tet_capacity(); ++t)
        if (c.alive(t)) {
          sum.first += price(work.quality(t));
          sum.second += work.quality(t) < 0.999 * price.low;
        }
      return sum;
    };
    for (int step = 0; step < 800; ++step) {
      const Index t = random_tet(c, random);
      const auto v = c.tet(t);
      const int i = static_cast<int>(random() % 4), j = static_cast<int>((i + 1 + random() % 3) % 4);
      price.steep = step % 2 == 0 ? 0 : 5;
      const auto before = rated();
      const double worst = worst_tet(c);
      const int kind = static_cast<int>(random() % 3);
      const bool ok = kind == 0   ? work.smooth_cheaper(v[i], price)
                      : kind == 1 ? work.collapse_cheaper(v[i], v[j], price)
                                  : work.insert_cheaper(t, price);
      const auto after = rated();
      done[kind] += ok;
      if (ok) {
        ASSERT_LT(after.first, before.first) << "operation " << kind;
        ASSERT_GE(worst_tet(c), 0.999 * std::min(worst, price.low)) << "operation " << kind;
        if (kind == 0) {
          ASSERT_LE(after.second, before.second);
        }
      } else {
        ASSERT_EQ(after, before) << "operation " << kind;
      }
    }
    test::expect_valid(c);
    EXPECT_EQ(boundary, test::boundary_faces(c));
  }
  for (int kind = 0; kind < 3; ++kind) EXPECT_GT(done[kind], 0) << "operation " << kind;
}

// The edge removal's dynamic programme against all triangulations of the ring polygon.
double best_by_hand(const std::vector<Eigen::Vector3d>& ring, const Eigen::Vector3d& a,
                    const Eigen::Vector3d& b, std::size_t i, std::size_t j) {
  if (j - i < 2) return 2;
  double best = 0;
  for (std::size_t k = i + 1; k < j; ++k)
    best = std::max(best, std::min({best_by_hand(ring, a, b, i, k), best_by_hand(ring, a, b, k, j),
                                    min_dihedral_sine(ring[i], ring[k], ring[j], b),
                                    min_dihedral_sine(ring[i], ring[j], ring[k], a)}));
  return best;
}

TEST(LocalOperations, EdgeRemovalFindsTheBestTriangulation) {
  const unsigned seed = 5;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  int removed = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const std::size_t n = 3 + trial % 6;
    std::vector<Eigen::Vector3d> ring;
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 2 * M_PI * (double(i) + 0.4 * uniform(random)) / double(n),
                   r = 0.5 + uniform(random);
      ring.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.3 * uniform(random));
    }
    const Eigen::Vector3d a(0, 0, -0.3 - uniform(random)), b(0, 0, 0.7 + uniform(random));
    TetMesh mesh;
    mesh.V.resize(n + 2, 3);
    mesh.T.resize(n, 4);
    mesh.V.row(n) = a;
    mesh.V.row(n + 1) = b;
    double old = 2;
    for (std::size_t i = 0; i < n; ++i) {
      mesh.V.row(i) = ring[i];
      mesh.T.row(i) << Index(n), Index(n + 1), Index(i), Index((i + 1) % n);
      old = std::min(old, min_dihedral_sine(a, b, ring[i], ring[(i + 1) % n]));
    }
    if (!(old > 0)) continue;
    TetComplex c(mesh.V, mesh.T);
    LocalOperations work(c);
    const double best = best_by_hand(ring, a, b, 0, n - 1);
    const bool ok = work.remove_edge(0, Index(n), Index(n + 1));
    EXPECT_EQ(best > old, ok);
    if (!ok) continue;
    ++removed;
    EXPECT_EQ(best, worst_tet(c));
    EXPECT_EQ(Index(2 * (n - 2)), c.tet_count());
    test::expect_valid(c);
  }
  EXPECT_GT(removed, 30);
}

// Two tets on a common face beside a third that already has the edge a flip would make.
TEST(LocalOperations, AnEdgeIsNeverMadeTwice) {
  const TetMesh mesh = test::grid_tets(1, 0, 1);
  TetComplex c(mesh.V, mesh.T);
  LocalOperations work(c);
  // The cube's diagonal 0-7 is its only interior edge; it may go, boundary edges may not.
  for (Index t = 0; t < 6; ++t)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const auto v = c.tet(t);
        if (i != j && !(std::min(v[i], v[j]) == 0 && std::max(v[i], v[j]) == 7)) {
          EXPECT_FALSE(work.remove_edge(t, v[i], v[j]));
          EXPECT_FALSE(work.split_edge(v[i], v[j], (c.position(v[i]) + c.position(v[j])) / 2));
          EXPECT_FALSE(work.collapse(v[i], v[j], 0));
        }
      }
  EXPECT_TRUE(work.split_edge(0, 7, {.5, .5, .5}));
  test::expect_valid(c);
}

TEST(LocalOperations, ThinLayersAreBlownUp) {
  for (const double height : {1e-3, 1e-6, 1e-9, 1e-12}) {
    const TetMesh mesh = test::grid_tets(2, 0, 1);
    TetComplex c(mesh.V, mesh.T);
    LocalOperations work(c);
    const Index t = 0;
    int k = 0;
    while (c.neighbour(t, k) >= 0) ++k;
    const auto v = c.tet(t);
    Eigen::Vector3d base = Eigen::Vector3d::Zero();
    for (int i = 0; i < 4; ++i)
      if (i != k) base += c.position(v[i]) / 3;
    ASSERT_TRUE(work.split_tet(t, base + height * (c.position(v[k]) - base)));
    ASSERT_LT(worst_tet(c), 10 * height);
    for (int i = 0; i < 5; ++i) work.smooth(c.vertex_count() - 1);
    EXPECT_GT(worst_tet(c), 0.1) << height;
    test::expect_valid(c);
  }
}

}  // namespace
}  // namespace overtet
