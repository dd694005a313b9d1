#include "src/covering/hinges.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <set>

#include "kernels/predicates/predicates.h"
#include "src/covering/pierced_edge.h"
#include "src/covering/wound_edges.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

const double kPi = std::acos(-1.0);

double solid_angle(const Surface& s, Index f, const Eigen::Vector3d& p) {
  const Eigen::Vector3d a = s.V.row(s.F(f, 0)).transpose() - p, b = s.V.row(s.F(f, 1)).transpose() - p,
                        c = s.V.row(s.F(f, 2)).transpose() - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

// Interior dihedral at half-edge h, in doubles.
double dihedral(const Surface& s, const SurfaceTopology& t, Index h) {
  const Eigen::Vector3d p = s.V.row(half_edge_source(s.F, h)), q = s.V.row(half_edge_target(s.F, h));
  const Eigen::Vector3d e = (q - p).normalized();
  const Eigen::Vector3d after = s.V.row(half_edge_opposite(s.F, h)).transpose() - p;
  const Eigen::Vector3d before = s.V.row(half_edge_opposite(s.F, t.twin[h])).transpose() - p;
  const Eigen::Vector3d u = after - e * e.dot(after), w = before - e * e.dot(before);
  const double theta = std::atan2(-e.dot(u.cross(w)), u.dot(w));
  return theta < 0 ? theta + 2 * kPi : theta;
}

// The integer straight from its definition: all faces, no rays. Not given where an angle is too close to a
// fold for doubles.
std::optional<double> b0_by_definition(const Surface& s, const SurfaceTopology& t, Index v) {
  double sum = 0;
  for (Index f = 0; f < s.F.rows(); ++f)
    if (s.F(f, 0) != v && s.F(f, 1) != v && s.F(f, 2) != v) sum += solid_angle(s, f, s.V.row(v));
  for (const Index h : half_edges_around(t, v)) {
    const double theta = dihedral(s, t, h);
    if (theta < 1e-9 || theta > 2 * kPi - 1e-9) return std::nullopt;
    sum += kPi - theta;
  }
  return sum / (2 * kPi) - 1;
}

double level_by_definition(const Surface& s, const SurfaceTopology& t, Index h, double at) {
  const Eigen::Vector3d p = s.V.row(half_edge_source(s.F, h)), q = s.V.row(half_edge_target(s.F, h));
  const Eigen::Vector3d x = p + at * (q - p);
  double sum = 0;
  for (Index f = 0; f < s.F.rows(); ++f)
    if (f != half_edge_face(h) && f != half_edge_face(t.twin[h])) sum += solid_angle(s, f, x);
  return sum / (4 * kPi) - dihedral(s, t, h) / (2 * kPi);
}

struct Studied {
  Surface surface;
  SurfaceTopology topology;
  TriangleBvh bvh;
  std::vector<FacePair> pairs;
  std::vector<Hinge> hinges;
  std::vector<PiercedEdge> pierced;
  explicit Studied(Surface s)
      : surface(std::move(s)),
        topology(require_topology(surface).value()),
        bvh(surface.V, surface.F),
        pairs(find_self_intersections(surface.V, surface.F)),
        hinges(find_hinges(surface, topology, bvh, pairs)),
        pierced(find_pierced_edges(surface, topology, pairs)) {}
};

// Models with self-crossings of all kinds, some turned inside out (which makes negative integers).
std::vector<Surface> crossing_models() {
  return {test::elbow(150, 16),       test::elbow(110, 12, 0.4), test::flipped(test::elbow(140, 12)),
          test::curled_worm(420, 10), test::saucer(2),           test::two_spheres(1)};
}

TEST(Hinges, EmbeddedVerticesHaveZero) {
  for (const Surface& s : {test::sphere(1), test::torus(12, 8), test::box(2), test::slab(1)}) {
    const Studied x(s);
    EXPECT_TRUE(x.hinges.empty());
    for (Index v = 0; v < s.V.rows(); ++v)
      EXPECT_EQ(vertex_b0(x.surface, x.topology, x.bvh, v), std::optional<int>(0)) << v;
  }
}

TEST(Hinges, IntegersEqualTheDefinition) {
  int hinges = 0, negative = 0, covered = 0;
  for (const Surface& s : crossing_models()) {
    const Studied x(s);
    hinges += static_cast<int>(x.hinges.size());
    const Index step = std::max<Index>(1, static_cast<Index>(s.V.rows()) / 150);
    std::set<Index> some;
    for (Index v = 0; v < s.V.rows(); v += step) some.insert(v);
    for (const Hinge& h : x.hinges) some.insert(h.vertex);
    for (const Index v : some) {
      const auto want = b0_by_definition(s, x.topology, v);
      if (!want) continue;
      const auto got = vertex_b0(x.surface, x.topology, x.bvh, v);
      ASSERT_TRUE(got.has_value()) << v;
      EXPECT_NEAR(*got, *want, 1e-5) << v;
      negative += *got < 0;
      covered += *got >= 2;
    }
    for (const Hinge& h : x.hinges) {
      EXPECT_EQ(h.B0, vertex_b0(x.surface, x.topology, x.bvh, h.vertex));
      EXPECT_FALSE(h.crossings.empty());
    }
  }
  EXPECT_GT(hinges, 0);
  EXPECT_GT(negative, 0);
  EXPECT_GT(covered, 0);
}

TEST(Hinges, LevelsAlongEdgesEqualTheDefinition) {
  int looked = 0, changing = 0;
  for (const Surface& s : crossing_models()) {
    const Studied x(s);
    std::vector<Index> edges;
    for (const PiercedEdge& e : x.pierced)
      if (edges.size() < 25) edges.push_back(e.half_edge);
    for (Index h = 0; h < 3 * s.F.rows() && edges.size() < 45; h += 17)
      if (h < x.topology.twin[h] && piercing_faces(x.pierced, x.topology, h).empty()) edges.push_back(h);
    for (const Index h : edges) {
      const std::vector<Index>& piercing = piercing_faces(x.pierced, x.topology, h);
      const auto levels = edge_levels(x.surface, x.topology, x.bvh, h, piercing);
      if (!levels) continue;
      std::set<int> seen;
      for (int i = 1; i < 20; ++i) {
        const double level = level_by_definition(s, x.topology, h, i / 20.0);
        if (std::fabs(level - std::round(level)) > 1e-5) continue;  // next to a crossing
        seen.insert(static_cast<int>(std::round(level)));
      }
      for (const int level : seen)
        EXPECT_TRUE(std::count(levels->begin(), levels->end(), level)) << "edge " << h;
      ++looked;
      changing += levels->size() > 1;
      // The other direction sees the same, reversed.
      auto reversed = *edge_levels(x.surface, x.topology, x.bvh, x.topology.twin[h], piercing);
      std::reverse(reversed.begin(), reversed.end());
      EXPECT_EQ(reversed, *levels);
    }
  }
  EXPECT_GT(looked, 50);
  EXPECT_GT(changing, 20);
}

TEST(Hinges, PiercedEdgesEqualBruteForce) {
  const Studied x(test::elbow(150, 10));
  const auto point = [&](Index v) { return x.surface.V.data() + 3 * v; };
  std::map<Index, std::set<Index>> want;
  for (Index h = 0; h < 3 * x.surface.F.rows(); ++h) {
    if (h > x.topology.twin[h]) continue;
    const Index a = half_edge_source(x.surface.F, h), b = half_edge_target(x.surface.F, h);
    for (Index g = 0; g < x.surface.F.rows(); ++g) {
      bool shares = false;
      for (int k = 0; k < 3; ++k) shares = shares || x.surface.F(g, k) == a || x.surface.F(g, k) == b;
      if (!shares && segment_triangle_intersect(point(a), point(b), point(x.surface.F(g, 0)),
                                                point(x.surface.F(g, 1)), point(x.surface.F(g, 2))))
        want[h].insert(g);
    }
  }
  std::map<Index, std::set<Index>> got;
  for (const PiercedEdge& e : x.pierced) got[e.half_edge] = {e.faces.begin(), e.faces.end()};
  EXPECT_FALSE(want.empty());
  EXPECT_EQ(got, want);
}

// Every equation of the theory, with capacities from the definition.
void check_equations(const Studied& x, const WoundEdges& wound) {
  std::map<Index, int> sum;
  for (const WoundEdge& e : wound.edges) {
    ASSERT_LT(e.a, e.b);
    ASSERT_GE(e.k, 1);
    sum[e.a] += e.k;
    sum[e.b] += e.k;
    const Index h = find_half_edge(x.surface.F, x.topology, e.a, e.b);
    ASSERT_GE(h, 0);
    for (int i = 1; i < 30; ++i)
      EXPECT_GT(level_by_definition(x.surface, x.topology, h, i / 30.0), e.k - 0.6) << e.a << " " << e.b;
  }
  std::set<Index> hinge;
  for (const Hinge& h : x.hinges) {
    hinge.insert(h.vertex);
    ASSERT_TRUE(h.B0.has_value());
    const int layers = *h.B0 - sum[h.vertex];
    EXPECT_GE(layers, 0);
    EXPECT_EQ(layers % 2, 0);
    EXPECT_LE(layers / 2, std::max(0, h.covering));
  }
  for (const auto& [v, k] : sum) {
    if (hinge.count(v)) continue;
    EXPECT_EQ(k % 2, 0);
    const auto b0 = vertex_b0(x.surface, x.topology, x.bvh, v);
    ASSERT_TRUE(b0.has_value());
    EXPECT_LE(k, *b0) << "chain through vertex " << v;
  }
}

TEST(WoundEdges, ElbowsAreJoinedByChains) {
  int chains = 0;
  for (const double degrees : {110.0, 130.0, 150.0}) {
    const Studied x(test::elbow(degrees, 16));
    const auto wound = assign_wound_edges(x.surface, x.topology, x.bvh, x.hinges, x.pierced, {});
    ASSERT_TRUE(wound.ok());
    if (!wound.value().complete()) {
      EXPECT_EQ(wound.value().explanation.empty(), wound.value().forbidden());  // that is for a rule to say
      continue;
    }
    check_equations(x, wound.value());
    chains += !wound.value().edges.empty();
  }
  EXPECT_GT(chains, 0);
}

TEST(WoundEdges, NoneWithoutHinges) {
  const Studied x(test::curled_worm());
  ASSERT_TRUE(x.hinges.empty());
  const auto wound = assign_wound_edges(x.surface, x.topology, x.bvh, x.hinges, x.pierced, {});
  ASSERT_TRUE(wound.ok());
  EXPECT_TRUE(wound.value().complete());
  EXPECT_TRUE(wound.value().edges.empty());
}

TEST(WoundEdges, DoNotDependOnTheOrderOfVertices) {
  const Surface s = test::elbow(150, 16);
  Eigen::VectorXi new_of_old;
  const Studied x(s), y(test::permuted(s, 5, &new_of_old));
  const auto a = assign_wound_edges(x.surface, x.topology, x.bvh, x.hinges, x.pierced, {});
  const auto b = assign_wound_edges(y.surface, y.topology, y.bvh, y.hinges, y.pierced, {});
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.value().complete(), b.value().complete());
  EXPECT_EQ(a.value().edges.size(), b.value().edges.size());
  EXPECT_EQ(a.value().odd_groups.size(), b.value().odd_groups.size());
}

}  // namespace
}  // namespace overtet
