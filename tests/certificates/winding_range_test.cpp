#include "src/certificates/winding_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "src/arrangement/intersection_graph.h"
#include "src/exact/winding.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

WindingRange range_of(const Surface& s, const WindingRangeOptions& options = {}) {
  const SurfaceTopology topology = require_topology(s).value();
  const TriangleBvh bvh(s.V, s.F);
  IntersectionGraph graph(s, topology, bvh, find_self_intersections(s.V, s.F));
  const auto range = find_winding_range(s, topology, bvh, graph, RunContext{}, options);
  EXPECT_TRUE(range.ok());
  EXPECT_EQ(range.value().undecided_pairs, 0);
  EXPECT_EQ(range.value().witness.has_value(), range.value().min < 0);
  return range.value();
}

void expect_certified(const Surface& s, const WindingRange& range) {
  ASSERT_TRUE(range.witness.has_value());
  const WindingNumber winding(s);
  EXPECT_EQ(winding.at(range.witness->exact), std::optional<int>(range.witness->winding));
  EXPECT_LT(range.witness->winding, 0);
  if (range.witness->doubles_suffice) {
    const auto at_doubles = winding.at(range.witness->point.data());
    ASSERT_TRUE(at_doubles.has_value());
    EXPECT_LT(*at_doubles, 0);
  }
}

TEST(Witness, RangesThatAreKnown) {
  struct Case {
    Surface surface;
    int min, max;
  };
  for (const Case& c :
       {Case{test::sphere(1), 0, 1}, Case{test::torus(), 0, 1}, Case{test::curled_worm(), 0, 2},
        Case{test::two_spheres(1), 0, 2}, Case{test::sphere_with_cavity(1), 0, 1},
        Case{test::bent_slab(), 0, 2}, Case{test::joined(test::sphere(1), test::sphere(1, 0.5)), 0, 2},
        Case{test::flipped(test::sphere(1)), -1, 0}, Case{test::saucer(2), -1, 1},
        Case{test::flipped(test::two_spheres(1)), -2, 0},
        Case{test::flipped(test::sphere_with_cavity(1)), -1, 0}}) {
    const WindingRange range = range_of(c.surface);
    EXPECT_EQ(range.min, c.min);
    EXPECT_EQ(range.max, c.max);
    if (c.min < 0) expect_certified(c.surface, range);
  }
}

// A sphere whose north pole is pushed out through the south by `depth`: a speck of negative winding.
Surface pushed_through(double depth) {
  Surface s = test::sphere(2);
  Index top = 0, bottom = 0;
  for (Index v = 0; v < s.V.rows(); ++v) {
    if (s.V(v, 2) > s.V(top, 2)) top = v;
    if (s.V(v, 2) < s.V(bottom, 2)) bottom = v;
  }
  s.V.row(top) = s.V.row(bottom);
  s.V(top, 0) += 0.03;
  s.V(top, 1) += 0.01;
  // The face below it, and a little farther out.
  s.V(top, 2) = s.V(bottom, 2) + 0.03;
  double lo = s.V(bottom, 2) - 1, hi = s.V(bottom, 2) + 0.5;
  for (int i = 0; i < 200; ++i) {  // to the last bit: the lowest place without intersections
    const double middle = 0.5 * (lo + hi);
    if (middle == lo || middle == hi) break;
    s.V(top, 2) = middle;
    SelfIntersectionOptions first;
    first.stop_at_first = true;
    (find_self_intersections(s.V, s.F, first).empty() ? hi : lo) = middle;
  }
  s.V(top, 2) = depth > 0 ? lo - depth : lo;
  return s;
}

TEST(Witness, SpecksOfAnySize) {
  for (const double depth : {1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 2e-16, 0.0}) {
    const Surface s = pushed_through(depth);
    const WindingRange range = range_of(s);
    if (depth == 0 && range.touching_pairs > 0 && range.min == 0) continue;  // it only touches
    EXPECT_EQ(range.min, -1) << depth;
    EXPECT_EQ(range.max, 1) << depth;
    expect_certified(s, range);
  }
}

TEST(Witness, StoppingEarlyFindsOneToo) {
  WindingRangeOptions quick;
  quick.stop_at_first_negative = true;
  const Surface s = test::saucer();
  expect_certified(s, range_of(s, quick));
  EXPECT_FALSE(range_of(test::elbow(), quick).witness.has_value());
}

TEST(Witness, CoincidentFaces) {
  // Two cubes side by side with a common wall, and one on top of itself.
  Surface a = test::box(3), b = a;
  b.V.col(0).array() += 1;
  const WindingRange beside = range_of(test::joined(a, b));
  EXPECT_EQ(beside.min, 0);
  EXPECT_EQ(beside.max, 1);
  const WindingRange twice = range_of(test::joined(a, a));
  EXPECT_EQ(twice.min, 0);
  EXPECT_EQ(twice.max, 2);
  const WindingRange gone = range_of(test::joined(a, test::flipped(a)));
  EXPECT_EQ(gone.min, 0);
  EXPECT_EQ(gone.max, 0);
  Surface c = test::flipped(a);
  c.V.col(0).array() += 0.5;  // coplanar sides, half outside
  const Surface half = test::joined(a, c);
  const WindingRange range = range_of(half);
  EXPECT_EQ(range.min, -1);
  EXPECT_EQ(range.max, 1);
  expect_certified(half, range);
}

// Boxes with corners on a lattice: nearly all pairs of faces lie in one plane, in many layers.
TEST(Witness, BoxesWithManyCoplanarSides) {
  constexpr unsigned kSeed = 77;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 6; ++trial) {
    int sum[4][4][4] = {};
    Surface all;
    for (int b = 0; b < 4; ++b) {
      const bool cavity = random() % 4 == 0;
      int lo[3], size[3];
      Surface box = test::box(1 + random() % 3);
      for (int k = 0; k < 3; ++k) {
        lo[k] = random() % 3;
        size[k] = 1 + random() % (4 - lo[k]);
        box.V.col(k).array() -= box.V.col(k).minCoeff();
        box.V.col(k) = (box.V.col(k) * size[k]).array() + lo[k];
      }
      for (int x = lo[0]; x < lo[0] + size[0]; ++x)
        for (int y = lo[1]; y < lo[1] + size[1]; ++y)
          for (int z = lo[2]; z < lo[2] + size[2]; ++z) sum[x][y][z] += cavity ? -1 : 1;
      if (cavity) box = test::flipped(box);
      all = b == 0 ? box : test::joined(all, box);
    }
    const int *first = &sum[0][0][0], *last = first + 64;
    const WindingRange range = range_of(all);
    EXPECT_EQ(range.min, std::min(0, *std::min_element(first, last)));
    EXPECT_EQ(range.max, std::max(0, *std::max_element(first, last)));
    if (range.witness) expect_certified(all, range);
  }
}

TEST(Witness, DoesNotDependOnThreadsOrderOrPlace) {
  const Surface s = test::saucer(2);
  const WindingRange want = range_of(s);
  for (const int threads : {2, 3, 8}) {
    const ScopedThreads scope(threads);
    const WindingRange got = range_of(s);
    EXPECT_EQ(got.witness->exact, want.witness->exact);
    EXPECT_EQ(got.negative_pairs, want.negative_pairs);
  }
  for (const Surface& other :
       {test::permuted(s, 11), test::transformed(s, test::some_rotation(3), Eigen::Vector3d(.3, -2, 5))}) {
    const WindingRange got = range_of(other);
    EXPECT_EQ(got.min, want.min);
    EXPECT_EQ(got.max, want.max);
  }
}

TEST(Witness, StopsWhenAsked) {
  const Surface s = test::saucer(2);
  const std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  const TriangleBvh bvh(s.V, s.F);
  const SurfaceTopology topology = require_topology(s).value();
  IntersectionGraph graph(s, topology, bvh, find_self_intersections(s.V, s.F));
  const auto range = find_winding_range(s, topology, bvh, graph, context);
  ASSERT_FALSE(range.ok());
  EXPECT_EQ(range.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace overtet
