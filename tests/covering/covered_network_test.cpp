#include "src/covering/covered_network.h"

#include <gtest/gtest.h>

#include <set>

#include "src/arrangement/intersection_graph.h"
#include "src/certificates/diagnose.h"
#include "src/exact/winding.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

struct Found {
  Surface surface;
  Diagnosis diagnosis;
  CoveredNetwork network;

  const SurfaceTopology& topology() const { return diagnosis.topology.topology; }
};

Found found(Surface s) {
  Found out;
  out.diagnosis = diagnose(s, {}, {}).value();
  out.network =
      find_covered_network(s, out.diagnosis.topology.topology, *out.diagnosis.bvh, *out.diagnosis.graph, {})
          .value();
  out.surface = std::move(s);
  return out;
}

// The winding number on the outer side of faces, a little off a point.
int level_at(const Surface& s, const WindingNumber& winding, Index f, const Eigen::Vector3d& p) {
  const Eigen::Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
  const Eigen::Vector3d q = p + 1e-9 * (b - a).cross(c - a).normalized();
  return winding.at(q.data()).value_or(0);
}

TEST(CoveredNetwork, RunsWhereTheSurfaceIsCovered) {
  for (int i = 0; i < 4; ++i) {
    const Found x = found(test::obstructed_elbow(i));
    EXPECT_EQ(x.network.problem, "");
    EXPECT_FALSE(x.network.points.empty());
    const WindingNumber winding(x.surface);
    const Index n = static_cast<Index>(x.surface.V.rows());
    const auto place = [&](Index v) {
      return v < n ? Eigen::Vector3d(x.surface.V.row(v))
                   : place_in_space(x.surface, x.network.points[static_cast<std::size_t>(v - n)]);
    };
    for (const CoveredNetwork::Link& l : x.network.links) {
      if (l.face < 0) continue;
      const Eigen::Vector3d middle = (place(l.a) + place(l.b)) / 2;
      EXPECT_GT(level_at(x.surface, winding, l.face, middle), 0) << "elbow " << i << ", face " << l.face;
    }
  }
}

TEST(CoveredNetwork, JoinsHingesThatNoEdgesPair) {
  for (int i = 0; i < 4; ++i) {
    const Found x = found(test::obstructed_elbow(i));
    ASSERT_FALSE(x.diagnosis.wound.odd_groups.empty());
    std::vector<Index> odd;
    for (const Hinge& h : x.diagnosis.hinges)
      if (h.B0 && *h.B0 % 2 != 0) odd.push_back(h.vertex);
    const std::vector<CoveredNetwork::Link> all = links_between(x.surface, x.network, odd);
    const std::vector<CoveredNetwork::Link> ways = pulled_tight(x.surface, x.topology(), x.network, all);
    ASSERT_FALSE(ways.empty()) << "elbow " << i;
    EXPECT_LE(ways.size(), all.size());
    for (const auto* links : {&all, &ways}) {
      const Additions added = additions(x.surface, x.network, *links);
      const Result<Subdivision> cut = subdivide(x.surface, x.topology(), added.points, added.edges);
      ASSERT_TRUE(cut.ok()) << cut.error().message;
      const Diagnosis d = diagnose(cut.value().surface, {}, {}).value();
      EXPECT_TRUE(d.wound.odd_groups.empty()) << "elbow " << i;
    }
  }
}

TEST(CoveredNetwork, LeavesOutLoopsAndTheLongerOfTwoWays) {
  const Surface s = test::sphere(1);
  const Index n = static_cast<Index>(s.V.rows());
  const auto chain = [](std::vector<CoveredNetwork::Link>& to, const std::vector<Index>& nodes) {
    for (std::size_t i = 1; i < nodes.size(); ++i) to.push_back({nodes[i - 1], nodes[i], 0, 1});
  };
  std::vector<CoveredNetwork::Link> kept, all;
  chain(kept, {0, n, 1});      // from vertex to vertex
  chain(kept, {3, n + 1, 4});  // the shorter way
  chain(kept, {4, n + 2});     // ends in a face
  all = kept;
  chain(all, {3, n + 3, n + 4, 4});          // the longer way
  chain(all, {2, n + 5, n + 6, 2});          // back to where it began
  chain(all, {n + 7, n + 8, n + 9, n + 7});  // without a beginning
  const auto keys = [](const std::vector<CoveredNetwork::Link>& links) {
    std::set<std::pair<Index, Index>> out;
    for (const CoveredNetwork::Link& l : links) out.insert(std::minmax({l.a, l.b}));
    return out;
  };
  EXPECT_EQ(keys(without_loops(s, all)), keys(kept));
  EXPECT_EQ(keys(without_loops(s, kept)), keys(kept));
}

TEST(CoveredNetwork, IsEmptyWhereNothingIsCovered) {
  const Found x = found(test::sphere(1));
  EXPECT_TRUE(x.network.points.empty() && x.network.links.empty() && x.network.problem.empty());
}

TEST(CoveredNetwork, SaysWhenASurfaceIsNotInGeneralPosition) {
  const Surface s = test::sphere(1);
  EXPECT_NE(found(test::joined(s, s)).network.problem, "");
}

}  // namespace
}  // namespace overtet
