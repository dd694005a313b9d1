#include "src/mesh/subdivision.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <random>
#include <set>

#include "tests/support/models.h"

namespace overtet {
namespace {

double face_area(const Surface& s, Index f) {
  const Eigen::Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
  return (b - a).cross(c - a).norm() / 2;
}

// Each face's pieces cover it, turned as it is turned.
void expect_same_shape(const Surface& s, const Subdivision& cut) {
  ASSERT_EQ(cut.face.size(), static_cast<std::size_t>(cut.surface.F.rows()));
  EXPECT_EQ(cut.surface.V.topRows(s.V.rows()), s.V);
  EXPECT_TRUE(check_topology(cut.surface).ok());
  EXPECT_TRUE(std::is_sorted(cut.face.begin(), cut.face.end()));
  std::map<Index, double> area;
  std::map<Index, int> count;
  for (Index f = 0; f < cut.surface.F.rows(); ++f) {
    area[cut.face[f]] += face_area(cut.surface, f);
    ++count[cut.face[f]];
  }
  ASSERT_EQ(area.size(), static_cast<std::size_t>(s.F.rows()));
  for (const auto& [f, a] : area) {
    EXPECT_NEAR(a, face_area(s, f), 1e-12) << "face " << f;
    EXPECT_EQ(count[f] > 1, std::binary_search(cut.pieced.begin(), cut.pieced.end(), f));
  }
}

bool has_edge(const Surface& s, Index a, Index b) {
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if ((s.F(f, k) == a && s.F(f, (k + 1) % 3) == b) || (s.F(f, k) == b && s.F(f, (k + 1) % 3) == a))
        return true;
  return false;
}

constexpr std::int64_t kHalf = kFaceGrid / 2, kQuarter = kFaceGrid / 4;

TEST(Subdivision, LeavesFacesWithoutPointsAlone) {
  const Surface s = test::sphere(1);
  const SurfaceTopology topology = check_topology(s).topology;
  const Result<Subdivision> cut = subdivide(s, topology, {}, {});
  ASSERT_TRUE(cut.ok());
  EXPECT_EQ(cut.value().surface.V, s.V);
  EXPECT_EQ(cut.value().surface.F, s.F);
  EXPECT_TRUE(cut.value().pieced.empty());
}

TEST(Subdivision, CutsBothFacesAtAPointOfAnEdge) {
  const Surface s = test::sphere(1);
  const SurfaceTopology topology = check_topology(s).topology;
  const Index n = static_cast<Index>(s.V.rows()), other = topology.twin[3 * 7] / 3;
  const FacePoint middle{7, {kHalf, kHalf, 0}};
  const Result<Subdivision> cut = subdivide(s, topology, {middle}, {});
  ASSERT_TRUE(cut.ok());
  expect_same_shape(s, cut.value());
  EXPECT_EQ(cut.value().pieced, (std::vector<Index>{std::min(Index{7}, other), std::max(Index{7}, other)}));
  EXPECT_TRUE(has_edge(cut.value().surface, n, s.F(7, 2)));
  const FacePoint beyond = seen_from_other_side(topology, middle);
  EXPECT_EQ(beyond.face, other);
  EXPECT_EQ(place_in_space(s, beyond), place_in_space(s, middle));
}

TEST(Subdivision, KeepsTheEdgesAskedFor) {
  const std::uint64_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  const Surface s = test::sphere(1);
  const SurfaceTopology topology = check_topology(s).topology;
  const Index n = static_cast<Index>(s.V.rows());
  for (int round = 0; round < 20; ++round) {
    // A zigzag of points in some faces, from a corner on: it never crosses itself.
    std::vector<FacePoint> points;
    std::vector<FaceEdge> edges;
    for (Index f = round % 3; f < s.F.rows(); f += 3) {
      Index before = s.F(f, 0);
      const int count = 1 + static_cast<int>(random() % 5);
      for (int i = 0; i < count; ++i) {
        const std::int64_t along = kFaceGrid * (i + 1) / (count + 1);
        const auto b = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(along - 1)) + 1;
        points.push_back({f, {kFaceGrid - along, b, along - b}});
        const Index id = n + static_cast<Index>(points.size()) - 1;
        edges.push_back({f, before, id});
        before = id;
      }
    }
    const Result<Subdivision> cut = subdivide(s, topology, points, edges);
    ASSERT_TRUE(cut.ok()) << cut.error().message;
    expect_same_shape(s, cut.value());
    for (const FaceEdge& e : edges) EXPECT_TRUE(has_edge(cut.value().surface, e.a, e.b));
  }
}

TEST(Subdivision, RefusesEdgesThatCrossAndPointsThatCoincide) {
  const Surface s = test::sphere(1);
  const SurfaceTopology topology = check_topology(s).topology;
  const Index n = static_cast<Index>(s.V.rows());
  const FacePoint a{3, {0, kHalf, kHalf}}, b{3, {kHalf, 0, kHalf}}, c{3, {kQuarter, kQuarter, kHalf}};
  // From corner 0 to the middle of the opposite side, and from corner 1 to that of its.
  EXPECT_FALSE(subdivide(s, topology, {a, b}, {{3, s.F(3, 0), n}, {3, s.F(3, 1), n + 1}}).ok());
  EXPECT_TRUE(subdivide(s, topology, {a, b}, {{3, s.F(3, 0), n}, {3, n, n + 1}}).ok());
  EXPECT_FALSE(subdivide(s, topology, {c, c}, {}).ok());
  EXPECT_FALSE(subdivide(s, topology, {a, seen_from_other_side(topology, a)}, {}).ok());
}

}  // namespace
}  // namespace overtet
