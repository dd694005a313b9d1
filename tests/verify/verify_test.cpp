#include "overtet/verification.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "kernels/core/tet_tables.h"
#include "kernels/parallel/parallel.h"

namespace overtet {
namespace {

// The faces of one tet only, in order of their tets: by brute force.
Surface boundary_of(const TetMesh& m, Index surface_vertices) {
  std::map<std::array<Index, 3>, int> uses;
  const auto key = [&](Index t, int k) {
    std::array<Index, 3> f = tet_face(m.T.row(t), k);
    std::sort(f.begin(), f.end());
    return f;
  };
  for (Index t = 0; t < m.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) ++uses[key(t, k)];
  Surface s;
  s.V = m.V.topRows(surface_vertices);
  for (Index t = 0; t < m.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      if (uses[key(t, k)] != 1) continue;
      s.F.conservativeResize(s.F.rows() + 1, 3);
      for (int c = 0; c < 3; ++c) s.F(s.F.rows() - 1, c) = m.T(t, kTetFace[k][c]);
    }
  return s;
}

struct Example {
  Surface surface;
  TetMesh mesh;
};

// A grid of n^3 cubes of six tets, numbered so that the boundary's vertices come first; points inside
// moved a little.
Example grid(int n, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  const auto unit = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; };
  const int m = n + 1;
  std::vector<Index> number(static_cast<std::size_t>(m * m * m), -1);
  const auto id = [&](int x, int y, int z) { return static_cast<std::size_t>((x * m + y) * m + z); };
  std::vector<Eigen::Vector3d> points;
  for (const bool inside : {false, true})
    for (int x = 0; x < m; ++x)
      for (int y = 0; y < m; ++y)
        for (int z = 0; z < m; ++z) {
          const bool in = x > 0 && y > 0 && z > 0 && x < n && y < n && z < n;
          if (in != inside) continue;
          number[id(x, y, z)] = static_cast<Index>(points.size());
          points.emplace_back(x, y, z);
          if (in) points.back() += 0.3 * Eigen::Vector3d(unit(), unit(), unit());
        }
  Example e;
  e.mesh.V.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v) e.mesh.V.row(static_cast<Eigen::Index>(v)) = points[v] / n;
  e.mesh.T.resize(6 * n * n * n, 4);
  Index t = 0;
  int axes[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z)
        for (int p = 0; p < 6; ++p) {
          int at[3] = {x, y, z};
          e.mesh.T(t, 0) = number[id(x, y, z)];
          for (int k = 0; k < 3; ++k) {
            ++at[axes[p][k]];
            e.mesh.T(t, k + 1) = number[id(at[0], at[1], at[2])];
          }
          if (p >= 3) std::swap(e.mesh.T(t, 2), e.mesh.T(t, 3));
          ++t;
        }
  e.mesh.surface_vertices = static_cast<Index>(m * m * m - (n - 1) * (n - 1) * (n - 1));
  e.surface = boundary_of(e.mesh, e.mesh.surface_vertices);
  return e;
}

// Tets around the edge 0-1 that make `turns` full turns; all other vertices on a ring.
Example around_edge(int tets, int turns) {
  Example e;
  e.mesh.V.resize(tets + 2, 3);
  e.mesh.V.row(0) << 0, 0, -1;
  e.mesh.V.row(1) << 0, 0, 1;
  for (int i = 0; i < tets; ++i) {
    const double a = 2 * std::numbers::pi * turns * i / tets;
    e.mesh.V.row(i + 2) << (1 + 0.01 * i) * std::cos(a), (1 + 0.01 * i) * std::sin(a), 0.001 * i;
  }
  e.mesh.T.resize(tets, 4);
  for (int i = 0; i < tets; ++i) e.mesh.T.row(i) << 0, 1, i + 2, (i + 1) % tets + 2;
  e.mesh.surface_vertices = tets + 2;
  e.surface = boundary_of(e.mesh, tets + 2);
  return e;
}

std::set<int> rules(const VerifyResult& r) {
  std::set<int> s;
  for (const VerifyFailure& f : r.failures) s.insert(static_cast<int>(f.rule));
  return s;
}
std::set<int> rules(const Example& e) { return rules(verify(e.surface, e.mesh)); }

using Set = std::set<int>;

TEST(Verify, AcceptsValidMeshes) {
  for (const int n : {1, 2, 4}) {
    const Example e = grid(n);
    const VerifyResult r = verify(e.surface, e.mesh);
    EXPECT_TRUE(r.ok()) << r.summary();
    EXPECT_EQ(r.boundary_faces, 12 * n * n);
    EXPECT_NEAR(tet_quality(e.mesh).volume, 1, 1e-12);
  }
  EXPECT_EQ(rules(around_edge(3, 1)), Set{});
  EXPECT_EQ(rules(around_edge(9, 1)), Set{});
}

TEST(Verify, R1) {
  Example e = grid(2);
  e.mesh.V(26, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(rules(e).contains(1));
  e = grid(2);
  e.mesh.T(3, 2) = 27;
  EXPECT_EQ(rules(e), Set{1});
  e.mesh.T(3, 2) = -1;
  EXPECT_EQ(rules(e), Set{1});
  e = grid(2);
  e.mesh.V.conservativeResize(28, 3);
  e.mesh.V.row(27) << 0.5, 0.5, 0.5;
  EXPECT_EQ(rules(e), Set{1});
  e.mesh.T.resize(0, 4);
  EXPECT_EQ(rules(e), Set{1});
}

TEST(Verify, R2) {
  Example e = grid(3);
  e.surface.V(5, 0) = std::nextafter(e.surface.V(5, 0), 2);
  const VerifyResult r = verify(e.surface, e.mesh);
  EXPECT_EQ(rules(r), Set{2});
  EXPECT_EQ(r.failures[0].first, std::vector<Index>{5});
  VerifyOptions loose;
  loose.max_move = 1e-12;
  EXPECT_TRUE(verify(e.surface, e.mesh, loose).ok());
  e.surface.V(5, 0) += 0.01;
  EXPECT_EQ(rules(verify(e.surface, e.mesh, loose)), Set{2});
}

TEST(Verify, R3) {
  // A tet taken away.
  Example e = grid(3);
  e.mesh.T.row(0) = e.mesh.T.row(e.mesh.T.rows() - 1);
  e.mesh.T.conservativeResize(e.mesh.T.rows() - 1, 4);
  EXPECT_TRUE(rules(e).contains(3));
  // A face of the surface turned round, missing, listed twice.
  e = grid(2);
  std::swap(e.surface.F(7, 0), e.surface.F(7, 1));
  EXPECT_EQ(rules(e), Set{3});
  e = grid(2);
  e.surface.F.conservativeResize(e.surface.F.rows() - 1, 3);
  EXPECT_EQ(rules(e), Set{3});
  e = grid(2);
  e.surface.F.conservativeResize(e.surface.F.rows() + 1, 3);
  e.surface.F.row(e.surface.F.rows() - 1) = e.surface.F.row(0);
  EXPECT_EQ(rules(e), Set{3});
  // A surface vertex that the surface does not know.
  e = grid(2);
  e.surface = boundary_of(e.mesh, 25);
  EXPECT_EQ(rules(e), Set{3});
}

TEST(Verify, R3ByCoordinates) {
  Example e = grid(2);
  VerifyOptions geometry;
  geometry.geometry_only = true;
  // Another numbering of the same surface.
  Surface s = e.surface;
  s.V = e.surface.V.colwise().reverse();
  for (Eigen::Index i = 0; i < s.F.size(); ++i)
    s.F.data()[i] = static_cast<Index>(s.V.rows()) - 1 - s.F.data()[i];
  EXPECT_TRUE(verify(s, e.mesh, geometry).ok());
  EXPECT_FALSE(verify(s, e.mesh).ok());
  s.V(0, 0) += 1e-15;
  EXPECT_EQ(rules(verify(s, e.mesh, geometry)), Set{3});
}

TEST(Verify, R4) {
  // The inner vertex pushed out through the boundary.
  Example e = grid(2);
  e.mesh.V.row(26) << 0.5, 0.5, 1.2;
  EXPECT_EQ(rules(e), Set{4});
  e.mesh.V.row(26) << 0.5, 0.5, 1.0;
  const VerifyResult flat = verify(e.surface, e.mesh);
  EXPECT_EQ(rules(flat), Set{4});
  EXPECT_NE(flat.summary().find("flat"), std::string::npos);
  // The smallest step inwards is enough.
  e.mesh.V.row(26) << 0.5, 0.5, std::nextafter(1.0, 0.0);
  EXPECT_EQ(rules(e), Set{});
}

TEST(Verify, R5) {
  // A tet listed twice.
  Example e = grid(2);
  e.mesh.T.conservativeResize(e.mesh.T.rows() + 1, 4);
  e.mesh.T.row(e.mesh.T.rows() - 1) = e.mesh.T.row(11);
  EXPECT_TRUE(rules(e).contains(5));
  // A tet turned inside out.
  e = grid(2);
  std::swap(e.mesh.T(20, 0), e.mesh.T(20, 1));
  EXPECT_TRUE(rules(e).contains(5));
  EXPECT_TRUE(rules(e).contains(4));
  // Two tets with a common vertex, and with a common edge: every face is fine, the links are not.
  for (const int common : {1, 2}) {
    Example two;
    two.mesh.V.resize(8 - common, 3);
    two.mesh.V.topRows(4) << 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0;
    if (common == 1)
      two.mesh.V.bottomRows(3) << -1, 0, 0, 0, 0, -1, 0, -1, 0;
    else
      two.mesh.V.bottomRows(2) << -1, 0, 0, 0, -1, 0;
    two.mesh.T.resize(2, 4);
    two.mesh.T.row(0) << 0, 2, 3, 1;
    if (common == 1)
      two.mesh.T.row(1) << 0, 4, 5, 6;
    else
      two.mesh.T.row(1) << 0, 4, 5, 1;
    two.mesh.surface_vertices = static_cast<Index>(two.mesh.V.rows());
    two.surface = boundary_of(two.mesh, two.mesh.surface_vertices);
    EXPECT_EQ(rules(two), Set{5}) << common;
  }
}

TEST(Verify, R6) {
  EXPECT_EQ(rules(around_edge(9, 2)), Set{6});
  EXPECT_EQ(rules(around_edge(23, 5)), Set{6});
  const VerifyResult r = verify(around_edge(9, 2).surface, around_edge(9, 2).mesh);
  EXPECT_EQ(r.failures.at(0).first, (std::vector<Index>{0, 1}));
  // The same tets, but not closed: a boundary edge may make more than a turn (a hinge).
  Example open = around_edge(11, 2);
  open.mesh.T.conservativeResize(8, 4);
  open.mesh.V.conservativeResize(11, 3);
  open.mesh.surface_vertices = 11;
  open.surface = boundary_of(open.mesh, 11);
  EXPECT_EQ(rules(open), Set{});
}

// Turns counted with orientations against turns counted with angles, on rings of random needles.
TEST(Verify, TurnsAgreeWithAngles) {
  const std::uint64_t seed = 4711;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (int i = 0; i < 200; ++i) {
    const int turns = 1 + static_cast<int>(random() % 3), tets = 3 * turns + static_cast<int>(random() % 5);
    Example e = around_edge(tets, turns);
    for (int v = 2; v < tets + 2; ++v) {
      const double r = std::ldexp(1, static_cast<int>(random() % 30) - 20);
      e.mesh.V(v, 0) *= r, e.mesh.V(v, 1) *= r;
      e.mesh.V(v, 2) += static_cast<double>(random() % 100);
    }
    e.surface = boundary_of(e.mesh, e.mesh.surface_vertices);
    EXPECT_EQ(rules(e), turns == 1 ? Set{} : Set{6}) << i;
  }
}

TEST(Verify, SameAnswerOnAnyNumberOfThreads) {
  Example e = grid(12);
  e.mesh.V.row(e.mesh.V.rows() - 1) *= 3;
  std::set<std::string> answers;
  for (const int threads : {1, 2, 3, 8}) {
    const ScopedThreads scope(threads);
    answers.insert(verify(e.surface, e.mesh).summary());
    const TetQuality q = tet_quality(e.mesh);
    answers.insert(std::to_string(q.dihedral_min) + std::to_string(q.volume));
  }
  EXPECT_EQ(answers.size(), 2u);
}

// Eight tets around an edge that make two turns, further out in the second one.
Example two_turns() {
  Example e;
  e.mesh.V.resize(10, 3);
  e.mesh.V.row(0) << 0, 0, -1;
  e.mesh.V.row(1) << 0, 0, 1;
  for (int i = 0; i < 8; ++i) {
    const double a = i * std::numbers::pi / 2, r = i < 4 ? 1 : 2;
    e.mesh.V.row(2 + i) << r * std::cos(a), r * std::sin(a), 0;
  }
  e.mesh.T.resize(8, 4);
  for (int i = 0; i < 8; ++i) e.mesh.T.row(i) << 0, 1, 2 + i, 2 + (i + 1) % 8;
  e.mesh.surface_vertices = 10;
  e.surface = boundary_of(e.mesh, 10);
  return e;
}

TEST(Verify, AllowsBranchLinesOnlyOnRequest) {
  const Example e = two_turns();
  const VerifyResult strict = verify(e.surface, e.mesh);
  ASSERT_EQ(strict.failures.size(), 1u) << strict.summary();
  EXPECT_TRUE(strict.fails(Rule::R6));
  EXPECT_TRUE(strict.branch_edges.empty());
  VerifyOptions options;
  options.allow_branches = true;
  const VerifyResult lax = verify(e.surface, e.mesh, options);
  EXPECT_TRUE(lax.ok()) << lax.summary();
  EXPECT_EQ(lax.branch_edges, (std::vector<std::array<Index, 2>>{{0, 1}}));
  // Nothing else is forgiven.
  Example turned = e;
  std::swap(turned.mesh.T(3, 0), turned.mesh.T(3, 1));
  EXPECT_TRUE(verify(turned.surface, turned.mesh, options).fails(Rule::R4));
  Example moved = e;
  moved.surface.V(5, 2) += 0.01;
  EXPECT_TRUE(verify(moved.surface, moved.mesh, options).fails(Rule::R2));
}

// Cross products of such coordinates leave the range of doubles.
TEST(Quality, IsThatOfAnOrdinarySizeAtAnySize) {
  const Example e = grid(3);
  const TetQuality one = tet_quality(e.mesh, {});
  for (const int exponent : {-1000, -600, -300, 300, 600, 1000}) {
    SCOPED_TRACE(exponent);
    TetMesh m = e.mesh;
    m.V = m.V.unaryExpr([&](double x) { return std::ldexp(x, exponent); });
    const TetQuality q = tet_quality(m, {});
    EXPECT_EQ(q.dihedral_min, one.dihedral_min);
    EXPECT_EQ(q.dihedral_p01, one.dihedral_p01);
    EXPECT_EQ(q.dihedral_max, one.dihedral_max);
    EXPECT_EQ(q.closest_pair, one.closest_pair);
    EXPECT_GT(q.volume, 0);
    EXPECT_TRUE(std::isfinite(q.volume));
    if (std::abs(exponent) == 300) EXPECT_EQ(q.volume, std::ldexp(one.volume, 3 * exponent));
  }
}

TEST(Quality, CountsVerticesInOnePlaceAndFindsTheClosestTwo) {
  Example e = grid(2);
  const double diagonal = std::sqrt(3.0) * (e.mesh.V.maxCoeff() - e.mesh.V.minCoeff());
  const TetQuality apart = tet_quality(e.mesh);
  EXPECT_EQ(0, apart.coincident_vertices);
  EXPECT_NEAR(apart.closest_pair,
              (e.mesh.V.row(apart.closest[0]) - e.mesh.V.row(apart.closest[1])).norm() / diagonal, 1e-12);
  e.mesh.V.row(3) = e.mesh.V.row(11);
  e.mesh.V.row(5) = e.mesh.V.row(11);
  const TetQuality q = tet_quality(e.mesh);
  EXPECT_EQ(3, q.coincident_vertices);
  EXPECT_EQ(0, q.closest_pair);
}

}  // namespace
}  // namespace overtet
