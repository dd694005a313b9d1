#include "src/cdt/domain_parts.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>

#include "kernels/parallel/parallel.h"
#include "src/cdt/delaunay_first.h"
#include "tests/cdt/sound.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

Result<TetgenResult> in_parts(const Plc& plc, Index facets_per_part, const RunContext& context = {}) {
  DelaunayMatch match(plc);
  if (auto error = match.run(context)) return *error;
  return mesh_in_parts(match, {facets_per_part}, context);
}

// Sound, really in parts, and the same on any number of threads.
void expect_sound_parts(const Plc& plc, Index facets_per_part, double volume) {
  Result<TetgenResult> first = Error{ErrorCode::internal, "not run"};
  for (const int threads : {1, 2, 3}) {
    const ScopedThreads scope(threads);
    Result<TetgenResult> r = in_parts(plc, facets_per_part);
    ASSERT_TRUE(r.ok()) << r.error().message;
    if (threads == 1) {
      EXPECT_GE(r.value().parts, plc.F.rows() / facets_per_part - 1);
      test::expect_sound(r.value(), plc, volume);
      first = std::move(r);
    } else {
      test::expect_same(first.value(), r.value());
    }
  }
}

Eigen::Matrix3d stretch() { return Eigen::Vector3d(1, 0.35, 0.55).asDiagonal(); }

// Stretched, so that many facets are no faces of Delaunay tets, and with another piece of surface nearby.
TEST(Parts, StretchedSurfaces) {
  const Surface ring = test::transformed(test::torus(64, 24), stretch() * test::some_rotation(4), {7, 0, 0});
  const Surface ball = test::transformed(test::sphere(3), stretch() * test::some_rotation(3), {7, 0, 0.01});
  const Surface both =
      test::joined(ring, test::transformed(ball, 0.3 * Eigen::Matrix3d::Identity(), {4.9, 0, 0}));
  expect_sound_parts(test::plc_of(both), 700, test::signed_volume(both));
}

// Walls inside, all of which are filled as well.
TEST(Parts, WallsInside) {
  const std::uint64_t seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-0.06, 0.06), size(0.03, 0.1);
  Surface all = test::sphere(4);
  const double volume = test::signed_volume(all);
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k) {
        const Eigen::Vector3d at(0.4 * i + shift(random), 0.4 * j + shift(random), 0.4 * k + shift(random));
        all = test::joined(
            all, test::transformed(test::sphere(2), size(random) * test::some_rotation(i + 3 * j), at));
      }
  all = test::transformed(all, stretch() * test::some_rotation(5), {1, 2, 3});
  expect_sound_parts(test::plc_of(all), 900, volume * stretch().determinant());
}

// Points in common planes and on common spheres.
TEST(Parts, Grid) { expect_sound_parts(test::plc_of(test::box(12)), 400, 1); }

TEST(Parts, ThinPlateWithHoles) {
  const Surface plate = test::slab(4, 6);
  expect_sound_parts(test::plc_of(plate), 300, test::signed_volume(plate));
}

// Facets that cross each other: parts get smaller until nothing else can be tried.
TEST(Parts, CrossingFacetsAreRefused) {
  const auto r = in_parts(test::plc_of(test::two_spheres(3)), 400);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::unsolved);
}

// A prism with many sides and one end turned: its faces are needles far from the Delaunay tets' edges.
Surface twisted_needles(int sides) {
  Surface s;
  s.V.resize(2 * sides + 2, 3);
  s.F.resize(4 * sides, 3);
  const Index low = 2 * sides, high = low + 1;
  s.V.row(low) << 0, 0, 0;
  s.V.row(high) << 0, 0, 2;
  for (Index i = 0; i < sides; ++i) {
    const Index j = (i + 1) % sides;
    const double angle = 2 * M_PI * i / sides, turned = angle + 1.5;
    s.V.row(i) << std::cos(angle), std::sin(angle), 0;
    s.V.row(sides + i) << std::cos(turned), std::sin(turned), 2;
    s.F.row(4 * i) << i, j, sides + i;
    s.F.row(4 * i + 1) << j, sides + j, sides + i;
    s.F.row(4 * i + 2) << j, i, low;
    s.F.row(4 * i + 3) << sides + i, sides + j, high;
  }
  return s;
}

TEST(Parts, NeedlesThatManyTetsAreInTheWayOfAreRefused) {
  const auto r = in_parts(test::plc_of(twisted_needles(400)), 700);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().message, "Missing facets pass through too many tets.");
}

TEST(Parts, SmallComplexesAndLoosePointsAreRefused) {
  Plc plc = test::plc_of(test::sphere(2));
  EXPECT_EQ(in_parts(plc, 10'000).error().code, ErrorCode::unsolved);
  EXPECT_TRUE(in_parts(plc, 100).ok());
  plc.V.conservativeResize(plc.V.rows() + 1, 3);
  plc.V.bottomRows(1).setConstant(0.01);
  EXPECT_EQ(in_parts(plc, 100).error().code, ErrorCode::unsolved);
}

TEST(Parts, WhereManyFacetsAreMissing) {
  const Surface ring = test::transformed(test::torus(64, 24), stretch() * test::some_rotation(4), {7, 0, 0});
  const Plc plc = test::plc_of(ring);
  const auto r =
      tetrahedralize_delaunay_first(plc, {}, {.most_missing = 0, .parts = {.facets_per_part = 700}});
  ASSERT_TRUE(r.ok()) << r.error().message;
  EXPECT_GT(r.value().missing_facets, 0);
  EXPECT_GT(r.value().parts, 1);
  test::expect_sound(r.value(), plc, test::signed_volume(ring));
}

TEST(Parts, StopWhenAsked) {
  const Plc plc = test::plc_of(test::sphere(4));
  DelaunayMatch match(plc);
  ASSERT_FALSE(match.run({}));
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  const auto r = mesh_in_parts(match, {1000}, context);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace overtet
