#include "src/cdt/free_points.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <string>

#include "kernels/parallel/parallel.h"
#include "src/cdt/delaunay_first.h"
#include "tests/cdt/sound.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"
#include "tests/support/prints.h"

namespace overtet {
namespace {

using test::expect_same;
using test::expect_sound;
using test::plc_of;

double distance_to_nearest(const Eigen::RowVector3d& p, const VertexMatrix& others) {
  double nearest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < others.rows(); ++i)
    if (const double d = (others.row(i) - p).norm(); d > 0) nearest = std::min(nearest, d);
  return nearest;
}

TEST(FreePoints, AreAsFarFromEachOtherAsFromTheSurface) {
  const std::uint64_t seed = 17;
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (const Surface& s : {test::noisy(test::sphere(4), seed, 0.03), test::torus(64, 32), test::box(12),
                           test::joined(test::sphere(3, 0.1), test::sphere(3, 1, {5, 0, 0}))}) {
    const VertexMatrix points = free_points(s.V, s.F, {});
    ASSERT_GT(points.rows(), 0);
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double from_surface = distance_to_nearest(points.row(i), s.V);
      // A cell of size a has no face within .4 a of its point, and vertices within sqrt(3) * 2 a.
      EXPECT_GT(distance_to_nearest(points.row(i), points), 0.1 * from_surface);
      for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
        Eigen::AlignedBox3d box;
        for (int k = 0; k < 3; ++k) box.extend(s.V.row(s.F(f, k)).transpose());
        EXPECT_GT(box.exteriorDistance(Eigen::Vector3d(points.row(i).transpose())), 0.1 * from_surface);
      }
    }
  }
}

TEST(FreePoints, AreTheSameOnAnyNumberOfThreads) {
  const Surface s = test::torus(96, 48);
  VertexMatrix first;
  for (const int threads : {1, 2, 5}) {
    const ScopedThreads scope(threads);
    const VertexMatrix points = free_points(s.V, s.F, {});
    if (threads == 1) first = points;
    EXPECT_EQ(points, first);
  }
}

// Needles pass through many cells, which are not divided for them.
TEST(FreePoints, AreFewAmongNeedles) {
  for (const test::Caps caps : {test::Caps::fan, test::Caps::strip, test::Caps::ears}) {
    const Surface s = test::rounded_plate(100, caps);
    EXPECT_LT(free_points(s.V, s.F, {}).rows(), s.V.rows());
  }
}

TEST(FreePoints, FewVerticesNeedNone) {
  const Surface s = test::box(1);
  EXPECT_EQ(free_points(s.V, s.F, {}).rows(), 0);
  EXPECT_EQ(free_points({}, {}, {}).rows(), 0);
}

Plc with_points(const Plc& plc, const VertexMatrix& points) {
  Plc more = plc;
  more.V.resize(plc.V.rows() + points.rows(), 3);
  more.V << plc.V, points;
  return more;
}

// Those inside become vertices, those outside leave no trace, and no facet is cut.
TEST(FreePoints, AreVerticesInside) {
  const std::uint64_t seed = 23;
  SCOPED_TRACE("seed " + std::to_string(seed));
  const Surface s =
      test::noisy(test::joined(test::torus(64, 32), test::sphere(4, 0.8, {4, 0, 0})), seed, 0.03);
  const Plc plc = plc_of(s);
  const VertexMatrix points = free_points(s.V, s.F, {});
  DelaunayFirstOptions options;
  options.free_points = static_cast<Index>(points.rows());
  options.parts.accept_split = false;
  options.in_parts = false;
  Result<TetgenResult> first = Error{ErrorCode::internal, "not run"};
  for (const int threads : {1, 2, 3}) {
    const ScopedThreads scope(threads);
    Result<TetgenResult> r = tetrahedralize_delaunay_first(with_points(plc, points), {}, options);
    ASSERT_TRUE(r.ok()) << r.error().message;
    if (threads > 1) {
      expect_same(first.value(), r.value());
      continue;
    }
    first = std::move(r);
    const TetgenResult& t = first.value();
    expect_sound(t, plc, test::signed_volume(s));
    EXPECT_GT(t.missing_facets, 0);
    EXPECT_EQ(t.facets.rows(), plc.F.rows());
    EXPECT_GT(t.free_points, 0);
    EXPECT_LT(t.free_points, points.rows());
    ASSERT_LE(plc.V.rows() + t.free_points, t.V.rows());
    // In the order in which they were given.
    Eigen::Index next = 0;
    for (Index i = 0; i < t.free_points; ++i) {
      while (next < points.rows() && points.row(next) != t.V.row(plc.V.rows() + i)) ++next;
      ASSERT_LT(next, points.rows());
    }
  }
}

// Half the facets of a grid are no faces of Delaunay tets: TetGen gets all of it then, and keeps its promise.
TEST(FreePoints, WhereTheyAreOfNoUseTetgenKeepsFacetsWhole) {
  for (const Surface& s : {test::box(6), test::slab(2)}) {
    const Plc plc = plc_of(s);
    TetgenOptions options;
    options.free_points = true;
    const auto r = tetrahedralize_stubbornly(plc, options, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    expect_sound(r.value(), plc, test::signed_volume(s));
    EXPECT_EQ(r.value().facets.rows(), plc.F.rows());
  }
}

}  // namespace
}  // namespace overtet
