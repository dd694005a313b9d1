#include "src/mesh/polyhedron.h"
#include "kernels/core/triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "kernels/tet_energy/tet_quality.h"

namespace overtet {
namespace {

using Eigen::Vector3d;
using Face = Polyhedron::Face;
using Tet = Polyhedron::Tet;

struct Shape {
  std::vector<Vector3d> points;
  std::vector<Tet> tets;
};

std::array<Face, 4> inner_faces(const Tet& t) {
  return {{{t[0], t[1], t[2]}, {t[1], t[0], t[3]}, {t[2], t[1], t[3]}, {t[0], t[2], t[3]}}};
}

Face back(const Face& f) { return rotated(Face{f[1], f[0], f[2]}); }

std::set<Face> hull_of(const std::vector<Tet>& tets) {
  std::set<Face> hull;
  for (const Tet& t : tets)
    for (const Face& f : inner_faces(t))
      if (!hull.erase(back(f))) hull.insert(rotated(f));
  return hull;
}

double quality(const Shape& s, const Tet& t) {
  return min_dihedral_sine(s.points[t[0]], s.points[t[1]], s.points[t[2]], s.points[t[3]]);
}

// All ways to fill from any open face on, without a thought.
double best_by_hand(const Shape& s, std::set<Face> open, std::set<std::array<int, 3>> used, double worst) {
  if (open.empty()) return worst;
  const Face f = *open.begin();
  double best = 0;
  for (int v = 0; v < static_cast<int>(s.points.size()); ++v) {
    if (v == f[0] || v == f[1] || v == f[2]) continue;
    const Tet t{f[0], f[1], f[2], v};
    const double q = quality(s, t);
    if (!(q > 0)) continue;
    auto now_open = open;
    auto now_used = used;
    bool fits = true;
    for (const Face& g : inner_faces(t)) {
      Face sorted = g;
      std::sort(sorted.begin(), sorted.end());
      if (now_open.erase(rotated(g))) continue;
      if (!now_used.insert(sorted).second) fits = false;
      now_open.insert(back(g));
    }
    if (fits) best = std::max(best, best_by_hand(s, now_open, now_used, std::min(worst, q)));
  }
  return best;
}

// The ring of an edge, with a point inside one of its tets now and then.
Shape random_ring(std::mt19937& random, int n) {
  std::uniform_real_distribution<double> uniform(0, 1);
  Shape s;
  for (int i = 0; i < n; ++i) {
    const double angle = 2 * M_PI * (i + 0.5 * uniform(random)) / n, r = 0.5 + uniform(random);
    s.points.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.5 * uniform(random));
  }
  s.points.emplace_back(0, 0, -0.2 - uniform(random));
  s.points.emplace_back(0, 0, 0.7 + uniform(random));
  for (int i = 0; i < n; ++i) s.tets.push_back({n, n + 1, i, (i + 1) % n});
  if (n < 5 && uniform(random) < 0.5) {
    const Tet t = s.tets.back();
    s.tets.pop_back();
    Vector3d sum = Vector3d::Zero();
    double weights = 0;
    for (const int v : t) {
      const double w = 0.1 + uniform(random);
      sum += w * s.points[v];
      weights += w;
    }
    s.points.emplace_back(sum / weights);
    for (const Face& f : inner_faces(t)) s.tets.push_back({f[0], f[1], f[2], n + 2});
  }
  return s;
}

TEST(Polyhedron, FindsTheBestFilling) {
  const unsigned seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  int better = 0;
  Polyhedron p;
  for (int trial = 0; trial < 200; ++trial) {
    const Shape s = random_ring(random, 3 + trial % 3);
    double old = 1;
    for (const Tet& t : s.tets) old = std::min(old, quality(s, t));
    if (!(old > 0)) continue;
    const std::set<Face> hull = hull_of(s.tets);
    std::set<std::array<int, 3>> used;
    for (Face f : hull) {
      std::sort(f.begin(), f.end());
      used.insert(f);
    }
    const double best = best_by_hand(s, hull, used, 1);
    ASSERT_GE(best, old - 1e-12);

    p.clear();
    for (const Vector3d& x : s.points) p.add_point(x);
    for (const Face& f : hull) p.add_face(f);
    std::vector<Tet> tets;
    const double found = p.fill(0, 1000000, tets);
    EXPECT_TRUE(p.complete());
    EXPECT_NEAR(best, found, 1e-12);
    EXPECT_EQ(hull, hull_of(tets));
    double worst = 1;
    for (const Tet& t : tets) worst = std::min(worst, quality(s, t));
    EXPECT_NEAR(best, worst, 1e-12);
    better += best > old * (1 + 1e-9);
    // Again, on the same polyhedron: nothing is better than the best.
    EXPECT_EQ(0, p.fill(found * (1 + 1e-9), 1000000, tets));
    EXPECT_TRUE(tets.empty());
    EXPECT_EQ(0, p.fill(0, 1, tets));
    EXPECT_FALSE(p.complete());
  }
  EXPECT_GT(better, 30);
}

TEST(Polyhedron, WhatIsBarredIsNotMade) {
  // Two tets on a common face: three around the edge 3-4 would be better.
  Shape s;
  for (int i = 0; i < 3; ++i)
    s.points.emplace_back(std::cos(2 * M_PI * i / 3), std::sin(2 * M_PI * i / 3), 0);
  s.points.emplace_back(0, 0, 0.3);
  s.points.emplace_back(0, 0, -0.3);
  s.tets = {{0, 1, 2, 3}, {1, 0, 2, 4}};
  Polyhedron p;
  const auto fill = [&](bool edge, bool face) {
    p.clear();
    for (const Vector3d& x : s.points) p.add_point(x);
    for (const Face& f : hull_of(s.tets)) p.add_face(f);
    if (edge) p.bar_edge(4, 3);
    if (face) p.bar_face(2, 0, 1);
    std::vector<Tet> tets;
    p.fill(0, 1000, tets);
    return tets.size();
  };
  EXPECT_EQ(3u, fill(false, false));
  EXPECT_EQ(2u, fill(true, false));
  EXPECT_EQ(3u, fill(false, true));
  EXPECT_EQ(0u, fill(true, true));
}

}  // namespace
}  // namespace overtet
