#include "src/covering/shared_points.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "src/certificates/diagnose.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

Diagnosis diagnosed(const Surface& s) {
  Result<Diagnosis> d = diagnose(s, {}, {});
  EXPECT_TRUE(d.ok());
  return std::move(d).value();
}

// Shaken, with a sphere around one of its hinges.
Surface pierced_elbow(std::uint64_t seed) {
  const Surface s =
      test::noisy(test::elbow(90 + 20.0 * static_cast<double>(seed % 6), 8 + static_cast<int>(seed % 5)),
                  seed, 0.02 + 0.03 * static_cast<double>(seed % 7));
  const std::vector<Hinge> hinges = diagnosed(s).hinges;
  if (hinges.empty()) return s;
  const Eigen::Vector3d at = s.V.row(hinges[seed % hinges.size()].vertex);
  return test::joined(s, test::sphere(1, 0.1 + 0.1 * static_cast<double>(seed % 5),
                                      at + 0.05 * Eigen::Vector3d(0.3, 0.5, 0.7)));
}

// A little sphere, one vertex of which lies where v does.
Surface touched(const Surface& s, Index v, double radius) {
  Surface other = test::sphere(0, radius);
  const Eigen::RowVector3d move = s.V.row(v) - other.V.row(0);
  other.V.rowwise() += move;
  other.V.row(0) = s.V.row(v);
  return test::joined(s, other);
}

// What a single hinge needs is what its link says, whoever asks.
TEST(Shared, AloneAHingeNeedsWhatItsLinkDoes) {
  int wrong = 0, right = 0;
  for (std::uint64_t seed = 120; seed < 180; ++seed) {
    SCOPED_TRACE(seed);
    const Surface s = pierced_elbow(seed);
    const Diagnosis d = diagnosed(s);
    if (d.certificate && !d.wound.forbidden()) continue;  // another rule has decided
    std::vector<Index> all, expected = d.wound.crowded, got;
    for (const Hinge& h : d.hinges) all.push_back(h.vertex);
    expected.insert(expected.end(), d.wound.unfillable.begin(), d.wound.unfillable.end());
    std::sort(expected.begin(), expected.end());
    const auto shared = find_shared(s, d.topology.topology, *d.bvh, d.hinges, d.pierced_edges, all, {});
    ASSERT_TRUE(shared.ok());
    for (const SharedPoint& p : shared.value()) {
      ASSERT_EQ(p.vertices.size(), 1u);
      EXPECT_GT(p.layers[0], p.room);
      got.push_back(p.vertices[0]);
    }
    EXPECT_EQ(got, expected);
    wrong += static_cast<int>(expected.size());
    right += static_cast<int>(all.size() - expected.size());
  }
  EXPECT_GT(wrong, 3);
  EXPECT_GT(right, 30);
}

// Copies in one place, and a part that touches: what a hinge needs stays what it needs, and what has a mesh
// is not said to have none.
TEST(Shared, CopiesAndTouchingPartsChangeNothing) {
  int certified = 0;
  for (const std::uint64_t seed : {131, 137, 353}) {
    SCOPED_TRACE(seed);
    const Surface s = pierced_elbow(seed);
    const Diagnosis d = diagnosed(s);
    ASSERT_FALSE(d.hinges.empty());
    const std::vector<Index>& named = d.wound.crowded.empty() ? d.wound.unfillable : d.wound.crowded;
    const Index v = named.empty() ? d.hinges[0].vertex : named[0];
    for (const Surface& more : {test::joined(s, s), touched(s, v, 0.01)}) {
      const Diagnosis other = diagnosed(more);
      EXPECT_EQ(other.verdict, d.verdict) << other.message;
      if (named.empty() || !other.wound.odd_groups.empty()) continue;
      ASSERT_TRUE(other.wound.shared);
      EXPECT_EQ(other.wound.shared->vertices[0], v);
      ++certified;
    }
  }
  EXPECT_GE(certified, 4);
}

// Each copy of what has no mesh by itself can do with a layer of what is around it, but one layer is enough
// for one only.
TEST(Shared, LayersAreNotThereTwice) {
  for (int i = 0; i < 2; ++i) {
    SCOPED_TRACE(i);
    const Surface one = test::obstructed_elbow(i), around = test::sphere(2, 20);
    Surface s = around;
    for (int copies = 1; copies <= 2; ++copies) {
      s = test::joined(s, one);
      const Diagnosis d = diagnosed(s);
      if (copies == 1) {
        EXPECT_EQ(d.verdict, Verdict::feasible) << d.message;
        continue;
      }
      EXPECT_EQ(d.verdict, Verdict::infeasible);
      ASSERT_TRUE(d.wound.shared);
      EXPECT_EQ(d.wound.shared->layers, (std::vector<int>{1, 1}));
      EXPECT_EQ(d.wound.shared->room, 1);
    }
  }
}

}  // namespace
}  // namespace overtet
