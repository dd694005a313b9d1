#include "src/arrangement/intersection_graph.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "kernels/parallel/parallel.h"
#include "tests/arrangement/studied.h"

namespace overtet {
namespace {

using exact::Point;
using exact::Rational;
using exact::Rays;
using exact::Vec;
using test::Studied;
using test::three_spheres;

// By rational arithmetic alone: 1 inside the face, 0 on its border, -1 elsewhere.
int where(const Rays& rays, Index f, const Vec& x) {
  const Vec n = rays.normal(f);
  if (exact::sign(dot(n, x - exact::vec(rays.corner(f, 0)))) != 0) return -1;
  int out = 1;
  for (int k = 0; k < 3; ++k) {
    const Vec a = exact::vec(rays.corner(f, k)), b = exact::vec(rays.corner(f, (k + 1) % 3));
    out = std::min(out, exact::sign(dot(n, exact::cross(b - a, x - a))));
  }
  return out;
}

std::vector<Surface> models() {
  return {test::elbow(150, 12), test::elbow(110, 10, 0.4), test::curled_worm(420, 8),
          test::saucer(2),      test::two_spheres(1),      three_spheres(1)};
}

TEST(IntersectionGraph, SegmentsEndOnBothFaces) {
  int hinges = 0;
  for (const Surface& s : models()) {
    Studied x(s);
    ASSERT_TRUE(x.graph.prepare_all(x.rays, {}));
    ASSERT_FALSE(x.graph.segments().empty());
    for (const auto& segment : x.graph.segments()) {
      EXPECT_LT(segment.node[0], segment.node[1]);
      for (int e = 0; e < 2; ++e) {
        const Vec& at = x.graph.position(segment.node[e]).x;
        EXPECT_GE(where(x.rays, segment.faces.first, at), 0);
        EXPECT_GE(where(x.rays, segment.faces.second, at), 0);
        // The segment goes no further.
        const Vec& other = x.graph.position(segment.node[1 - e]).x;
        const Vec beyond = at + Rational(1, 1000) * (at - other);
        EXPECT_TRUE(where(x.rays, segment.faces.first, beyond) < 0 ||
                    where(x.rays, segment.faces.second, beyond) < 0);
        hinges += segment.ends[e][0] == segment.ends[e][1];
      }
    }
  }
  EXPECT_GT(hinges, 0);
}

TEST(IntersectionGraph, ThirdFacesCutWhereBruteForceSays) {
  int cuts = 0;
  for (const Surface& s : models()) {
    Studied x(s);
    ASSERT_TRUE(x.graph.prepare_all(x.rays, {}));
    for (Index i = 0; i < static_cast<Index>(x.graph.segments().size()); ++i) {
      const auto& segment = x.graph.segments()[i];
      const Vec &a = x.graph.position(segment.node[0]).x, &b = x.graph.position(segment.node[1]).x;
      std::map<Index, Rational> want, got;
      for (Index h = 0; h < s.F.rows(); ++h) {
        if (h == segment.faces.first || h == segment.faces.second) continue;
        const Vec n = x.rays.normal(h), o = exact::vec(x.rays.corner(h, 0));
        const Rational from = dot(n, a - o), to = dot(n, b - o);
        if (exact::sign(from) * exact::sign(to) >= 0) continue;
        const Rational t = from / (from - to);
        if (where(x.rays, h, a + t * (b - a)) >= 0) want[h] = t;
      }
      Rational last = 0;
      for (const auto& cut : x.graph.cuts(i).places) {
        const Rational t = x.graph.place(x.rays, i, cut);
        EXPECT_LT(last, t);
        EXPECT_NEAR(cut.near, t.get_d(), cut.error + 1e-15);
        last = t;
        for (const Index h : cut.faces)
          if (want.count(h)) got[h] = t;
      }
      EXPECT_LT(last, 1);
      EXPECT_EQ(got, want);
      cuts += static_cast<int>(want.size());
    }
  }
  EXPECT_GT(cuts, 0);
}

// Three boxes in one place, moved along their faces: pairs in one plane, segments along edges.
TEST(IntersectionGraph, KindsInSpecialPosition) {
  Surface s = test::box(1);
  for (const double shift : {0.25, 0.5}) {
    Surface other = test::box(1);
    other.V.rowwise() += Eigen::RowVector3d(shift, 0, 0);
    s = test::joined(s, other);
  }
  Studied x(s);
  ASSERT_TRUE(x.graph.prepare_all(x.rays, {}));
  std::set<IntersectionGraph::Kind> seen;
  int along_edges = 0, in_plane = 0;
  for (std::size_t i = 0; i < x.pairs.size(); ++i) seen.insert(x.graph.kind(i));
  for (Index i = 0; i < static_cast<Index>(x.graph.segments().size()); ++i) {
    along_edges += !x.graph.segments()[i].plain();
    in_plane += x.graph.cuts(i).overlaid;
  }
  EXPECT_TRUE(seen.count(IntersectionGraph::Kind::coplanar));
  EXPECT_TRUE(seen.count(IntersectionGraph::Kind::segment));
  EXPECT_FALSE(seen.count(IntersectionGraph::Kind::nothing));
  EXPECT_GT(along_edges, 0);
  EXPECT_GT(in_plane, 0);
}

TEST(IntersectionGraph, IsTheSameInPartsAndOnAnyThreads) {
  const Surface s = test::curled_worm(420, 8);
  Studied x(s), y(s);
  ASSERT_TRUE(x.graph.prepare_all(x.rays, {}));
  const ScopedThreads threads(2);
  const Index n = static_cast<Index>(y.graph.segments().size());
  for (Index i = 0; i < n; i += 7) ASSERT_TRUE(y.graph.prepare(y.rays, i, std::min(n, i + 7), {}));
  for (Index i = 0; i < n; ++i) {
    ASSERT_EQ(x.graph.segments()[i].node, y.graph.segments()[i].node);
    ASSERT_EQ(x.graph.cuts(i).places.size(), y.graph.cuts(i).places.size());
    for (std::size_t k = 0; k < x.graph.cuts(i).places.size(); ++k)
      EXPECT_EQ(x.graph.cuts(i).places[k].near, y.graph.cuts(i).places[k].near);
  }
}

}  // namespace
}  // namespace overtet
