#include "src/immersion/immersion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <atomic>
#include <cstdio>
#include <set>
#include <string>

#include "kernels/parallel/parallel.h"
#include "tests/support/immersed/shapes.h"

namespace overtet {
namespace {

using test::failure_of;

Surface shifted(const Surface& s, double x, double y, double z) {
  return test::transformed(s, Eigen::Matrix3d::Identity(), Eigen::Vector3d(x, y, z));
}

std::string bytes_of(const TetMesh& m) {
  std::string out(reinterpret_cast<const char*>(m.V.data()), sizeof(double) * m.V.size());
  out.append(reinterpret_cast<const char*>(m.T.data()), sizeof(Index) * m.T.size());
  return out;
}

TEST(Immersion, MeshesWhatCrossesItself) {
  const std::pair<const char*, Surface> models[] = {{"curled worm", test::curled_worm(420, 12)},
                                                    {"worm of two turns", test::curled_worm(800, 8)},
                                                    {"slab", test::bent_slab(2, 390, 3)},
                                                    {"two spheres", test::two_spheres(2)},
                                                    {"sphere with cavity", test::sphere_with_cavity(1)},
                                                    {"sphere", test::sphere(1)}};
  for (const auto& [name, s] : models) {
    SCOPED_TRACE(name);
    ImmersionResult r;
    EXPECT_EQ(failure_of(s, &r), "");
    EXPECT_EQ(r.winding_max, test::diagnosed(s).winding.max);
    double volume = tet_quality(r.mesh).volume;
    EXPECT_NEAR(volume, test::signed_volume(s), 1e-10);
  }
}

TEST(Immersion, MeshesATubeWhoseCopiesChangePlaces) { EXPECT_EQ(failure_of(test::thick_knot()), ""); }

TEST(Immersion, MeshesHinges) {
  for (const int around : {12, 16, 24}) {
    const Surface s = test::elbow(150, around);
    ASSERT_FALSE(test::diagnosed(s).hinges.empty());
    EXPECT_EQ(failure_of(s), "") << around << " around";
  }
}

// A sheet that crosses wound edges puts points on them, which must come off the boundary there as well.
TEST(Immersion, MeshesHingesWhoseWoundEdgesArePierced) {
  const Surface s = test::pierced_elbow();
  const Diagnosis d = test::diagnosed(s);
  bool pierced = false;
  for (const WoundEdge& w : d.wound.edges) pierced |= w.pierced;
  ASSERT_TRUE(pierced);
  EXPECT_EQ(failure_of(s), "");
}

TEST(Immersion, MeshesWhatCoincidesOrTouches) {
  const Surface tube = test::capsule(2, 0.5, 10), cube = test::box(2);
  const std::pair<const char*, Surface> models[] = {
      {"equal tubes", test::joined(tube, tube)},
      {"tubes 1e-9 apart", test::joined(tube, shifted(tube, 1e-9, 2e-9, -1e-9))},
      {"boxes with a face in common", test::joined(cube, shifted(cube, 1, 0, 0))},
      {"boxes that touch in part", test::joined(cube, shifted(cube, 1, 0.25, 0.125))},
      {"boxes that touch in an edge", test::joined(cube, shifted(cube, 1, 1, 0.25))},
      {"boxes that touch in a corner", test::joined(cube, shifted(cube, 1, 1, 1))},
      {"boxes with sides in one plane", test::joined(cube, shifted(cube, 0.5, 0.25, 0))}};
  for (const auto& [name, s] : models) {
    SCOPED_TRACE(name);
    EXPECT_EQ(failure_of(s), "");
  }
}

// Surfaces closer together than doubles can cut apart.
TEST(Immersion, NearCoincidence) {
  const Surface tube = test::capsule(1.5, 0.5, 8);
  const double offsets[][3] = {{0, 1e-8, 0},           {3e-11, 5e-11, 7e-11},  {1e-11, 0, 0},
                               {1e-12, 2e-12, -1e-12}, {9e-13, -2e-13, 4e-13}, {0, 1e-13, 0},
                               {1e-15, 2e-15, -1e-15}, {1e-16, 0, 0}};
  for (const auto& o : offsets) {
    SCOPED_TRACE(testing::Message() << o[0] << ", " << o[1] << ", " << o[2]);
    EXPECT_EQ(failure_of(test::joined(tube, shifted(tube, o[0], o[1], o[2]))), "");
  }
}

// A model beside a copy of itself that is turned by almost nothing: the curves in which the two cross are
// noise.
TEST(Immersion, NearlyCoincidentByATurn) {
  const Surface s = test::sphere(1);
  for (const double angle : {1e-13, 1e-10, 1e-7, 1e-4}) {
    SCOPED_TRACE(angle);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    EXPECT_EQ(failure_of(test::joined(s, test::transformed(s, turn, Eigen::Vector3d::Zero()))), "");
  }
}

// Boxes with many sides in common planes, turned so that rounding puts them beside each other.
TEST(Immersion, TiltedBoxesWithSidesInOnePlane) {
  const auto box = [](int cells, Eigen::Vector3d low, Eigen::Vector3d high) {
    return test::transformed(test::box(cells), (high - low).asDiagonal(), low);
  };
  Surface s = box(2, {0, 0, 0}, {3, 2, 4});
  s = test::joined(s, box(3, {1, 0, 1}, {4, 3, 4}));
  s = test::joined(s, box(1, {0, 1, 0}, {3, 3, 2}));
  s = test::joined(s, box(4, {1, 0, 0}, {3, 3, 4}));
  for (const std::uint64_t seed : {1, 2, 3}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    ImmersionResult r;
    EXPECT_EQ(failure_of(test::transformed(s, test::some_rotation(seed), Eigen::Vector3d::Zero()), &r), "");
  }
}

TEST(Immersion, WithoutInteriorPointsToo) {
  EXPECT_EQ(failure_of(test::curled_worm(420, 10), nullptr, 0), "");
  EXPECT_EQ(failure_of(test::elbow(150, 14), nullptr, 0), "");
}

TEST(Immersion, NegativeWindingHasNoSheets) {
  const Surface s = test::saucer(2);
  const Diagnosis d = test::diagnosed(s);
  const auto r = immerse(s, d.pairs, d.wound.edges, {}, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::unsolved);  // the certificate is the diagnosis's task
}

TEST(Immersion, SameBytesOnAnyNumberOfThreads) {
  for (const Surface& s : {test::curled_worm(410, 10), test::elbow(150, 12)}) {
    std::set<std::string> results;
    for (const int threads : {1, 2, 3, 8}) {
      const ScopedThreads cap(threads);
      ImmersionResult r;
      EXPECT_EQ(failure_of(s, &r), "");
      results.insert(bytes_of(r.mesh));
    }
    EXPECT_EQ(results.size(), 1u);
  }
}

TEST(Immersion, DoesNotDependOnTheNumbersOfVertices) {
  for (const std::uint64_t seed : {1, 2}) {
    EXPECT_EQ(failure_of(test::permuted(test::elbow(150, 14), seed)), "") << "seed " << seed;
    EXPECT_EQ(failure_of(test::permuted(test::curled_worm(420, 10), seed)), "") << "seed " << seed;
  }
}

// A part that has a mesh has one beside anything else that has one: the solid of both is the two solids.
// Points on the edges of one that rounding moves across them make no difference.
TEST(Immersion, PartsThatHaveAMeshHaveOneTogether) {
  for (const auto& [degrees, around] : {std::pair{170.0, 6}, {170.0, 20}, {190.0, 6}}) {
    const Surface bent = test::elbow(degrees, around);
    ASSERT_EQ(failure_of(bent), "");
    const Diagnosis d = test::diagnosed(bent);
    ASSERT_FALSE(d.hinges.empty());
    const Eigen::Vector3d a = bent.V.row(d.hinges.front().vertex);
    double far = 0;
    for (const Hinge& h : d.hinges) far = std::max(far, (Eigen::Vector3d(bent.V.row(h.vertex)) - a).norm());
    for (const auto& [radius, seed] : {std::pair{0.53, 13}, {0.9, 15}, {1.2, 16}}) {
      SCOPED_TRACE(testing::Message() << degrees << " degrees, " << around << " around, ball " << radius);
      const Surface ball =
          test::transformed(test::sphere(seed == 16 ? 1 : 0), radius * far * test::some_rotation(seed),
                            a + Eigen::Vector3d(0.0123, 0.0071, -0.0057));
      EXPECT_EQ(failure_of(test::joined(bent, ball)), "");
    }
  }
}

// Random bends: a mesh that passes the exact check, or a reason why there is none.
TEST(Immersion, RandomWormsAreMeshedOrProvenImpossible) {
  int meshed = 0, crossing = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Surface s = test::random_worm(seed);
    const Diagnosis d = test::diagnosed(s);
    if (d.verdict == Verdict::infeasible) continue;
    crossing += !d.pairs.empty();
    const std::string failure = failure_of(s);
    EXPECT_EQ(failure, "") << "seed " << seed;
    meshed += failure.empty();
  }
  std::printf("seeds 1 to 20: %d meshed, %d of those tried cross themselves\n", meshed, crossing);
  EXPECT_GE(crossing, 5);
}

TEST(Immersion, OptionsAreChecked) {
  ImmersionOptions options;
  options.radius_edge = 0.5;
  EXPECT_FALSE(options.validate().ok());
  const auto r = immerse(test::sphere(0), {}, {}, options, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::usage);
}

TEST(Immersion, StopsWhenAsked) {
  const Surface s = test::curled_worm(410, 10);
  const Diagnosis d = test::diagnosed(s);
  std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  const auto r = immerse(s, d.pairs, d.wound.edges, {}, context);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace overtet
