#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <limits>
#include <map>
#include <set>

#include "kernels/bvh/self_intersections.h"
#include "kernels/core/tuning.h"
#include "kernels/predicates/predicates.h"
#include "src/cdt/facet_recovery.h"
#include "src/cdt/split_edges.h"
#include "src/cdt/tetgen.h"
#include "src/cdt/tuning.h"
#include "tests/cdt/sound.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

// A cube with a wall in the middle.
Plc divided_box() {
  const Surface s = test::box(2);
  Plc plc;
  plc.V = s.V;
  plc.F = s.F;
  Index middle[3][3];
  for (Index v = 0; v < s.V.rows(); ++v)
    if (s.V(v, 0) == 0.5) middle[static_cast<int>(2 * s.V(v, 1))][static_cast<int>(2 * s.V(v, 2))] = v;
  plc.V.conservativeResize(s.V.rows() + 1, 3);
  plc.V.row(s.V.rows()) << 0.5, 0.5, 0.5;
  middle[1][1] = static_cast<Index>(s.V.rows());
  const Index n = static_cast<Index>(s.F.rows());
  plc.F.conservativeResize(n + 8, 3);
  Index f = n;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      plc.F.row(f++) << middle[i][j], middle[i + 1][j], middle[i + 1][j + 1];
      plc.F.row(f++) << middle[i][j], middle[i + 1][j + 1], middle[i][j + 1];
    }
  for (Index g = 0; g < plc.F.rows(); ++g) plc.markers.push_back(g + 7);
  return plc;
}

TEST(TetgenStubborn, IsTetgenWhereThatSucceeds) {
  for (const bool quality : {false, true}) {
    TetgenOptions options;
    options.quality = quality;
    const Plc plc = divided_box();
    const auto a = tetrahedralize(plc, options, {}), b = tetrahedralize_stubbornly(plc, options, {});
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(a.value().V, b.value().V);
    EXPECT_EQ(a.value().T, b.value().T);
    EXPECT_EQ(a.value().neighbours, b.value().neighbours);
    EXPECT_EQ(a.value().facets, b.value().facets);
    EXPECT_EQ(a.value().facet_markers, b.value().facet_markers);
    EXPECT_EQ(a.value().facet_sources, b.value().facet_sources);
  }
}

// Every attempt keeps the promises of the first one: it only shows TetGen the same thing in another order.
TEST(TetgenStubborn, EveryAttemptKeepsThePromises) {
  // With a cavity in one half, and a point whose numbers rounding would change.
  Plc plc = divided_box();
  plc.V.row(0) += Eigen::RowVector3d(-0x1p-40, -0x1p-45, -0x1p-50);
  const Eigen::Vector3d centre(0.75, 0.3, 0.4);
  const Surface hole = test::sphere(0, 0.1, centre);
  const Index vertices = static_cast<Index>(plc.V.rows()), faces = static_cast<Index>(plc.F.rows());
  plc.V.conservativeResize(vertices + hole.V.rows(), 3);
  plc.V.bottomRows(hole.V.rows()) = hole.V;
  plc.F.conservativeResize(faces + hole.F.rows(), 3);
  plc.F.bottomRows(hole.F.rows()) = (hole.F.array() + vertices).matrix();
  for (Index f = 0; f < hole.F.rows(); ++f) plc.markers.push_back(1000 + f);
  plc.holes.resize(1, 3);
  plc.holes.row(0) = centre.transpose();
  for (int number = 0; number < kOrders; ++number)
    for (const bool quality : {false, true}) {
      SCOPED_TRACE(number);
      TetgenOptions options;
      options.quality = quality;
      const auto r = tetrahedralize_in_order(plc, options, {}, number);
      ASSERT_TRUE(r.ok()) << r.error().message;
      const TetgenResult& t = r.value();
      ASSERT_GE(t.V.rows(), plc.V.rows());
      EXPECT_EQ(0, std::memcmp(t.V.data(), plc.V.data(), sizeof(double) * plc.V.size()));
      double volume = 0;
      for (Index i = 0; i < t.T.rows(); ++i) {
        const auto p = [&](int k) { return t.V.data() + 3 * t.T(i, k); };
        EXPECT_GT(orient3d(p(0), p(1), p(2), p(3)), 0);
        const Eigen::RowVector3d a = t.V.row(t.T(i, 0));
        volume += (t.V.row(t.T(i, 1)) - a).cross(t.V.row(t.T(i, 2)) - a).dot(t.V.row(t.T(i, 3)) - a) / 6;
        for (int k = 0; k < 4; ++k) {
          const Index other = t.neighbours(i, k);
          if (other < 0) continue;
          int common = 0;
          for (int m = 0; m < 4; ++m)
            for (int o = 0; o < 4; ++o) common += m != k && t.T(i, m) == t.T(other, o);
          EXPECT_EQ(common, 3);
        }
      }
      EXPECT_NEAR(volume, 1 - test::signed_volume(hole), 1e-9);
      std::set<Index> sources;
      ASSERT_EQ(t.facets.rows(), plc.F.rows());
      for (Index f = 0; f < t.facets.rows(); ++f) {
        const Index source = t.facet_sources[f];
        EXPECT_TRUE(sources.insert(source).second);
        EXPECT_EQ(t.facet_markers[f], plc.markers[source]);
        std::set<Index> got, want;
        for (int k = 0; k < 3; ++k) got.insert(t.facets(f, k)), want.insert(plc.F(source, k));
        EXPECT_EQ(got, want);
      }
    }
}

TEST(TetgenStubborn, SaysNoAsTetgenDoes) {
  Plc plc = divided_box();
  plc.V(0, 0) = std::numeric_limits<double>::infinity();
  const auto r = tetrahedralize_stubbornly(plc, {}, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::bad_input);
  // Facets that cross: every attempt fails, and the first one's reason is given.
  const Surface crossing = test::two_spheres(0);
  const Plc bad{crossing.V, crossing.F, {}, {}};
  const auto a = tetrahedralize(bad, {}, {}), b = tetrahedralize_stubbornly(bad, {}, {});
  ASSERT_FALSE(a.ok() || b.ok());
  EXPECT_EQ(b.error().code, a.error().code);
  EXPECT_EQ(b.error().message, a.error().message);
}

// A flat and long surface: many facets are no faces of Delaunay tets.
Plc stretched() {
  Surface s = test::transformed(test::torus(24, 10), test::some_rotation(4), {0, 0, 0});
  s = test::transformed(s, Eigen::Vector3d(1, 0.1, 0.3).asDiagonal(), {0, 0, 0});
  return test::plc_of(s);
}

TEST(TetgenStubborn, EdgesAreCutWithoutChangingTheSurface) {
  const Plc plc = stretched();
  const auto split = split_missing_edges(plc, {});
  ASSERT_TRUE(split);
  const Plc& now = split->plc;
  EXPECT_EQ(now.V.topRows(plc.V.rows()), plc.V);
  EXPECT_GT(now.F.rows(), plc.F.rows());
  EXPECT_TRUE(find_self_intersections(now.V, now.F).empty());
  const auto normal = [](const Plc& p, Index f) {
    const Eigen::Vector3d a = p.V.row(p.F(f, 0)), b = p.V.row(p.F(f, 1)), c = p.V.row(p.F(f, 2));
    return Eigen::Vector3d((b - a).cross(c - a));
  };
  std::vector<Eigen::Vector3d> sum(plc.F.rows(), Eigen::Vector3d::Zero());
  std::map<std::pair<Index, Index>, int> sides;
  for (Index f = 0; f < now.F.rows(); ++f) {
    const Index source = split->source[f];
    EXPECT_EQ(now.markers[f], plc.markers[source]);
    EXPECT_GT(normal(now, f).dot(normal(plc, source)), 0);
    sum[source] += normal(now, f);
    for (int k = 0; k < 3; ++k) {
      ++sides[{now.F(f, k), now.F(f, (k + 1) % 3)}];
      --sides[{now.F(f, (k + 1) % 3), now.F(f, k)}];
    }
  }
  for (const auto& [edge, count] : sides) EXPECT_EQ(count, 0);  // still closed
  for (Index f = 0; f < plc.F.rows(); ++f)
    EXPECT_LT((sum[f] - normal(plc, f)).norm(), 1e-12 * normal(plc, f).norm());
}

TEST(TetgenStubborn, AttemptsAreCounted) {
  TetgenOptions options;
  options.patience = 1e-6;  // 3 facets
  Attempts few(options);
  const Error failed{ErrorCode::unsolved, "TetGen failed."};
  EXPECT_FALSE(few.count(2, failed).ok());
  EXPECT_TRUE(few.another_order());
  EXPECT_FALSE(few.count(100, failed).ok());
  EXPECT_FALSE(few.left());
  EXPECT_FALSE(few.any_endless());

  Attempts attempts(TetgenOptions{});
  const Error endless{ErrorCode::unsolved, "", std::nullopt, ErrorReason::endless};
  for (int i = 0; i < kInVain; ++i) {
    EXPECT_TRUE(attempts.another_order());
    EXPECT_FALSE(attempts.count(1, endless).ok());
  }
  EXPECT_FALSE(attempts.another_order());
  EXPECT_TRUE(attempts.left() && attempts.any_endless());
  attempts.other_facets();
  EXPECT_TRUE(attempts.another_order());
}

TEST(TetgenStubborn, CutEdgesKeepThePromises) {
  const Plc plc = stretched();
  TetgenOptions options;
  options.quality = false;
  options.accept_split = true;
  Attempts attempts(options);
  const auto r = tetrahedralize_split(plc, options, {}, attempts);
  ASSERT_TRUE(r.ok()) << r.error().message;
  EXPECT_GT(r.value().V.rows(), plc.V.rows());
  Surface s;
  s.V = plc.V;
  s.F = plc.F;
  test::expect_sound(r.value(), plc, test::signed_volume(s));
}

}  // namespace
}  // namespace overtet
