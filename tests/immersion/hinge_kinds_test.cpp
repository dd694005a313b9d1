// Hinges of all kinds, each with an answer that is known by construction: a solution was made first
// (tests/support/stairs.h), or two solutions were put into one place.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>

#include "tests/support/immersed/shapes.h"
#include "tests/support/noise.h"
#include "tests/support/stairs.h"

namespace overtet {
namespace {

using test::failure_of;
using test::spiral_stairs;
using test::Stairs;
using test::StairsOptions;

std::map<Index, int> b0_of_hinges(const Diagnosis& d) {
  std::map<Index, int> out;
  for (const Hinge& h : d.hinges)
    if (h.B0) out[h.vertex] = *h.B0;
  return out;
}

// The known mesh is one, the diagnosis finds the known integers, and the stage finds a mesh.
void expect_known_answer(const Stairs& s) {
  EXPECT_EQ(test::check(s.surface, s.mesh), "") << "the known mesh";
  const Diagnosis d = test::diagnosed(s.surface);
  EXPECT_EQ(d.verdict, Verdict::feasible) << d.message;
  EXPECT_TRUE(d.wound.complete()) << d.wound.explanation;
  const auto b0 = b0_of_hinges(d);
  for (const Index end : {s.axis.front(), s.axis.back()}) {
    ASSERT_TRUE(b0.count(end)) << "vertex " << end;
    EXPECT_EQ(b0.at(end), s.wound) << "vertex " << end;
  }
  EXPECT_EQ(failure_of(s.surface), "");
}

// One edge or a chain; B0 = 1, 2 (a link that crosses itself twice), 3.
TEST(HingeKinds, WoundOnceTwiceAndThrice) {
  for (const double turns : {1.05, 1.3, 1.7, 2.2, 2.6, 3.3})
    for (const int edges : {1, 2, 5}) {
      SCOPED_TRACE(testing::Message() << turns << " turns, " << edges << " edges");
      const Stairs s = spiral_stairs({.turns = turns, .edges = edges});
      expect_known_answer(s);
      // The chain of the axis is what is wound: nothing else is covered all along.
      const Diagnosis d = test::diagnosed(s.surface);
      ASSERT_EQ(static_cast<int>(d.wound.edges.size()), edges);
      for (const WoundEdge& w : d.wound.edges) {
        EXPECT_EQ(w.k, s.wound);
        EXPECT_EQ(w.b, w.a + 1);
      }
    }
}

// Winding numbers for which not all ways of gluing can be listed.
TEST(HingeKinds, WoundManyTimes) {
  for (const double turns : {5.4, 7.3, 9.3}) {
    SCOPED_TRACE(turns);
    expect_known_answer(spiral_stairs({.turns = turns, .edges = 2}));
  }
}

// So many needles around the axis that TetGen fails in every order of points: edges are cut in half for it.
TEST(HingeKinds, WoundTooOftenForTetgen) { expect_known_answer(spiral_stairs({.turns = 10.3, .edges = 2})); }

// Chains with different numbers of turns meet at one vertex.
TEST(HingeKinds, TwoAtOneVertex) {
  for (const double turns : {0.6, 1.3, 2.2})
    for (const double longer : {1.0, 2.1}) {
      SCOPED_TRACE(testing::Message() << turns << " turns, then " << longer << " more");
      const Stairs s = spiral_stairs({.turns = turns, .edges = 3, .longer = longer});
      ASSERT_EQ(test::check(s.surface, s.mesh), "");
      ASSERT_GT(s.wound_last, s.wound);
      const Diagnosis d = test::diagnosed(s.surface);
      EXPECT_EQ(d.verdict, Verdict::feasible) << d.message;
      auto b0 = b0_of_hinges(d);
      EXPECT_EQ(b0[s.axis[0]], s.wound);
      EXPECT_EQ(b0[s.axis[2]], s.wound + s.wound_last);
      EXPECT_EQ(b0[s.axis[3]], s.wound_last);
      EXPECT_EQ(failure_of(s.surface), "");
    }
}

// Whatever the angle, there is a mesh or a reason why there is none.
TEST(HingeKinds, ElbowsOfAnyAngle) {
  int meshed = 0;
  for (int degrees = 60; degrees <= 330; degrees += 15) {
    SCOPED_TRACE(degrees);
    const Surface s = test::elbow(degrees, 8 + degrees % 4);
    if (test::diagnosed(s).verdict != Verdict::feasible) continue;
    EXPECT_EQ(failure_of(s), "");
    ++meshed;
  }
  EXPECT_GE(meshed, 8);
}

TEST(HingeKinds, ChainsAlongABentAxis) {
  for (const double bend : {0.1, 0.2, 0.3}) {
    SCOPED_TRACE(bend);
    expect_known_answer(spiral_stairs({.turns = 1.4, .edges = 4, .bend = bend}));
  }
}

// Noise makes hinges of other vertices, too, and moves crossings; the known tets stay a solution.
TEST(HingeKinds, NoisyStairsHaveAMesh) {
  int hinges = 0;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const double turns = 1.1 + 0.13 * static_cast<double>(seed % 9);
    const Stairs s =
        spiral_stairs({.turns = turns, .edges = 1 + static_cast<int>(seed % 4), .noise = 0.15, .seed = seed});
    ASSERT_EQ(test::check(s.surface, s.mesh), "");
    const Diagnosis d = test::diagnosed(s.surface);
    EXPECT_EQ(d.verdict, Verdict::feasible) << d.message;
    hinges += static_cast<int>(d.hinges.size());
    EXPECT_EQ(failure_of(s.surface), "");
  }
  EXPECT_GT(hinges, 48);
}

// What is wound does not have to be known beforehand.
TEST(HingeKinds, AreFoundWithoutWoundEdges) {
  for (const double turns : {1.3, 2.4})
    for (const int edges : {1, 3}) {
      SCOPED_TRACE(testing::Message() << turns << " turns, " << edges << " edges");
      const Stairs s = spiral_stairs({.turns = turns, .edges = edges});
      const Diagnosis d = test::diagnosed(s.surface);
      const auto r = immerse(s.surface, d.pairs, {}, {}, {});
      ASSERT_TRUE(r.ok()) << r.error().message;
      EXPECT_EQ(test::check(s.surface, r.value().mesh), "");
    }
}

// Where the wound edges given are wrong, those around them are tried first: the fewer edges are free, the
// fewer regions there are.
TEST(HingeKinds, WrongWoundEdgesArePutRightNearby) {
  const Stairs s = spiral_stairs({.turns = 1.4, .edges = 8, .bend = 0.1});
  const Diagnosis d = test::diagnosed(s.surface);
  const auto free = immerse(s.surface, d.pairs, {}, {}, {});
  ASSERT_TRUE(free.ok()) << free.error().message;
  ASSERT_EQ(d.wound.edges.size(), 8u);
  for (const std::size_t known : {1, 6, 8}) {
    SCOPED_TRACE(known);
    std::vector<WoundEdge> wrong(d.wound.edges.begin(), d.wound.edges.begin() + known);
    if (known == 8) wrong[3].k = 2;
    const auto r = immerse(s.surface, d.pairs, wrong, {}, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    EXPECT_EQ(test::check(s.surface, r.value().mesh), "");
    if (known > 1) {
      EXPECT_LT(r.value().regions, free.value().regions);
    }
  }
}

// Hinges inside another overlap: a ball around them adds a layer, to the winding and to what covers them.
TEST(HingeKinds, InsideOtherParts) {
  for (const double turns : {1.4, 2.3}) {
    SCOPED_TRACE(turns);
    const Stairs s = spiral_stairs({.turns = turns, .edges = 2});
    const Surface ball = test::transformed(test::sphere(1), 4 * test::some_rotation(3), {0.1, 0.2, 1});
    const Surface both = test::joined(s.surface, ball);
    const Diagnosis alone = test::diagnosed(s.surface), d = test::diagnosed(both);
    EXPECT_EQ(d.winding.max, alone.winding.max + 1);
    const auto b0 = b0_of_hinges(d);
    for (const Index end : {s.axis.front(), s.axis.back()}) {
      ASSERT_TRUE(b0.count(end));
      EXPECT_EQ(b0.at(end), s.wound + 2);
    }
    EXPECT_EQ(failure_of(both), "");
  }
}

// A ball whose surface crosses the wound chain, and a second staircase through the first.
TEST(HingeKinds, CrossedByOtherParts) {
  const Stairs s = spiral_stairs({.turns = 1.4, .edges = 3});
  const Surface ball = test::transformed(test::sphere(1), 0.8 * test::some_rotation(5), {0.1, 0.05, 0.4});
  EXPECT_EQ(failure_of(test::joined(s.surface, ball)), "");
  const Surface other = test::transformed(spiral_stairs({.turns = 1.7, .edges = 2}).surface,
                                          test::some_rotation(8), {0.3, -0.2, 0.9});
  EXPECT_EQ(failure_of(test::joined(s.surface, other)), "");
}

// A hinge whose region holds no path of edges: nothing can be wound, so there is no mesh, and the search,
// which has seen everything, says so, too.
TEST(HingeKinds, WithoutAPathHaveNoMesh) {
  for (int i = 0; i < 3; ++i) {
    SCOPED_TRACE(i);
    const Surface s = test::obstructed_elbow(i);
    const Diagnosis d = test::diagnosed(s);
    ASSERT_EQ(d.verdict, Verdict::infeasible);
    const auto r = immerse(s, d.pairs, d.wound.edges, {}, {});
    ASSERT_FALSE(r.ok());
    EXPECT_EQ(r.error().code, ErrorCode::unsolved);
    // Beside another part nothing gets better.
    EXPECT_NE(test::diagnosed(
                  test::joined(s, test::transformed(test::sphere(1), test::some_rotation(1), {9, 0, 0})))
                  .verdict,
              Verdict::feasible);
  }
}

}  // namespace
}  // namespace overtet
