#include "src/cdt/delaunay_first.h"

#include <gtest/gtest.h>

#include <atomic>

#include "kernels/parallel/parallel.h"
#include "tests/cdt/sound.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

using test::expect_same;
using test::expect_sound;
using test::plc_of;

constexpr DelaunayFirstOptions kAll{.most_missing = 1, .most_left = 10};  // whatever is missing

// Stretched, so that many facets are no faces of Delaunay tets; with a wall between two parts, and a cavity.
TEST(DelaunayFirst, StretchedSurfaces) {
  Eigen::Matrix3d stretch = Eigen::Vector3d(1, 0.35, 0.55).asDiagonal();
  const Surface ball = test::transformed(test::sphere_with_cavity(3, 0.4), test::some_rotation(3) * stretch,
                                         Eigen::Vector3d(0.1, 0.2, 0.3));
  const Surface ring =
      test::transformed(test::torus(48, 20), stretch * test::some_rotation(4), Eigen::Vector3d(7, 0, 0));
  const Plc plc = plc_of(test::joined(ball, ring));
  Result<TetgenResult> first = Error{ErrorCode::internal, "not run"};
  for (const int threads : {1, 2, 3}) {
    const ScopedThreads scope(threads);
    Result<TetgenResult> r = tetrahedralize_delaunay_first(plc, {}, kAll);
    ASSERT_TRUE(r.ok()) << r.error().message;
    if (threads == 1) {
      // TetGen fills the cavity as well: nothing says that it is one.
      const double volume = test::signed_volume(ring) + test::signed_volume(ball) * 1 / (1 - 0.064);
      expect_sound(r.value(), plc, volume);
      first = std::move(r);
      continue;
    }
    expect_same(first.value(), r.value());
  }
}

// Half the facets are missing, since points lie on common spheres and in common planes.
TEST(DelaunayFirst, GridsAreSoundOrRefused) {
  const Plc plc = plc_of(test::box(6));
  const auto r = tetrahedralize_delaunay_first(plc, {}, kAll);
  if (r.ok())
    expect_sound(r.value(), plc, 1);
  else
    EXPECT_EQ(r.error().code, ErrorCode::unsolved);
  TetgenOptions options;
  options.accept_split = true;
  const auto stubborn = tetrahedralize_stubbornly(plc, options, {});
  ASSERT_TRUE(stubborn.ok()) << stubborn.error().message;
  expect_sound(stubborn.value(), plc, 1);
}

TEST(DelaunayFirst, StopsWhenAsked) {
  const Plc plc = plc_of(test::sphere(4));
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  const auto r = tetrahedralize_delaunay_first(plc, context);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace overtet
