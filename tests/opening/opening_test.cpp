#include "src/opening/opening.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <set>
#include <vector>

#include "kernels/parallel/parallel.h"
#include "src/cdt/tetgen.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tet_complex.h"
#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

// A mesh, some surface vertices of which are pressed inwards until a tet is nearly flat, and where they would
// have been next: homes at which tets are not positive.
struct Pressed {
  TetMesh mesh;
  VertexMatrix home;
  std::set<Index> moved;
};

TetMesh filled_torus() {
  const Surface s = test::torus_surface(24, 12, 2, 0.7);
  TetgenOptions options;
  options.quality = true;
  const auto r = tetrahedralize({s.V, s.F, {}, {}}, options, {});
  EXPECT_TRUE(r.ok());
  return {r.value().V, r.value().T, static_cast<Index>(s.V.rows())};
}

Pressed pressed(unsigned seed, int wanted) {
  Pressed out{filled_torus(), {}, {}};
  VertexMatrix& V = out.mesh.V;
  out.home = V.topRows(out.mesh.surface_vertices);
  TetComplex c(V, out.mesh.T);
  LocalOperations work(c);
  std::mt19937 random(seed);
  std::vector<Index> star;
  for (int attempt = 0; attempt < 1000 && static_cast<int>(out.moved.size()) < wanted; ++attempt) {
    const Index v = static_cast<Index>(random() % static_cast<unsigned>(out.mesh.surface_vertices));
    c.star(v, star);
    Eigen::Vector3d inwards = Eigen::Vector3d::Zero();
    bool alone = true;
    for (const Index t : star)
      for (const Index w : c.tet(t)) {
        inwards += c.position(w) - c.position(v);
        alone = alone && !out.moved.contains(w);
      }
    if (!alone) continue;
    const Eigen::Vector3d from = c.position(v);
    double good = 0, bad = 1;
    if (work.place(v, from + bad * inwards)) {
      work.place(v, from);
      continue;
    }
    while (bad - good > 1e-4 * bad) {
      const double middle = (good + bad) / 2;
      (work.place(v, from + middle * inwards) ? good : bad) = middle;
    }
    work.place(v, from + good * inwards);
    out.home.row(v) = (from + 1.05 * bad * inwards).transpose();
    out.moved.insert(v);
  }
  for (Index v = 0; v < V.rows(); ++v) V.row(v) = c.position(v).transpose();
  return out;
}

TEST(Opening, MovedVerticesGetRoomAndNothingElseChanges) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    SCOPED_TRACE(seed);
    const Pressed start = pressed(seed, 6);
    ASSERT_GE(start.moved.size(), 3u);
    const double before = least_angle_at_moved(start.mesh, start.home);
    EXPECT_LT(before, 0.5);
    OpeningOptions options;
    options.largest_move = 1;
    options.most_helps = 0;
    TetMesh mesh = start.mesh;
    const auto r = open_up(mesh, start.home, options, {});
    ASSERT_TRUE(r.ok());
    EXPECT_NEAR(r.value().degrees_before, before, 1e-9);
    const double after = least_angle_at_moved(mesh, start.home);
    EXPECT_NEAR(r.value().degrees_after, after, 1e-9);
    EXPECT_GT(after, 2);
    const TetComplex c(mesh.V, mesh.T);
    test::expect_valid(c);
    ASSERT_EQ(mesh.surface_vertices, start.mesh.surface_vertices);
    EXPECT_EQ(test::boundary_faces(c), test::boundary_faces(TetComplex(start.mesh.V, start.mesh.T)));
    for (Index v = 0; v < mesh.surface_vertices; ++v)
      if (!start.moved.contains(v)) {
        EXPECT_EQ(mesh.V.row(v), start.mesh.V.row(v));
      }
  }
}

TEST(Opening, NoVertexGoesFurtherThanIsAllowed) {
  const Pressed start = pressed(4, 6);
  double farthest = 0;
  for (const Index v : start.moved)
    farthest = std::max(farthest, (start.mesh.V.row(v) - start.home.row(v)).norm());
  for (const double factor : {1.01, 1.2, 3.0}) {
    OpeningOptions options;
    options.largest_move = factor * farthest;
    TetMesh mesh = start.mesh;
    const auto r = open_up(mesh, start.home, options, {});
    ASSERT_TRUE(r.ok());
    double there = 0;
    for (const Index v : start.moved) there = std::max(there, (mesh.V.row(v) - start.home.row(v)).norm());
    EXPECT_LE(there, factor * farthest);
    double reported = 0;
    for (const OpenedPlace& place : r.value().places) reported = std::max(reported, place.farthest);
    EXPECT_DOUBLE_EQ(reported, there);
  }
}

// What the repair had moved in vain stayed away.
TEST(Opening, WhatNeedNotBeAwayGoesHome) {
  const TetMesh good = filled_torus();
  const VertexMatrix home = good.V.topRows(good.surface_vertices);
  TetMesh mesh = good;
  std::mt19937 random(7);
  TetComplex c(mesh.V, mesh.T);
  LocalOperations work(c);
  int away = 0;
  for (Index v = 0; v < good.surface_vertices; v += 5) {
    Eigen::Vector3d to = c.position(v);
    for (int k = 0; k < 3; ++k) to[k] += 0.1 * (static_cast<double>(random() % 1000) / 1000 - 0.5);
    away += work.place(v, to) ? 1 : 0;
  }
  ASSERT_GT(away, 10);
  for (Index v = 0; v < mesh.V.rows(); ++v) mesh.V.row(v) = c.position(v).transpose();
  OpeningOptions options;
  options.largest_move = 1;
  const auto r = open_up(mesh, home, options, {});
  ASSERT_TRUE(r.ok());
  EXPECT_EQ(mesh.V.topRows(mesh.surface_vertices), home);
  Index left = 0;
  for (const OpenedPlace& place : r.value().places) left += place.away;
  EXPECT_EQ(left, 0);
  EXPECT_EQ(least_angle_at_moved(mesh, home), 90);
  test::expect_valid(TetComplex(mesh.V, mesh.T));
}

// Where the balls end at once, moved vertices alone find no room.
TEST(Opening, NeighboursHelp) {
  for (const unsigned seed : {11u, 12u, 13u}) {
    SCOPED_TRACE(seed);
    const Pressed start = pressed(seed, 6);
    OpeningOptions options;
    options.largest_move = 1;
    const auto angle = [&](int helps) {
      options.most_helps = helps;
      TetMesh mesh = start.mesh;
      EXPECT_TRUE(open_up(mesh, start.home, options, {}).ok());
      test::expect_valid(TetComplex(mesh.V, mesh.T));
      return least_angle_at_moved(mesh, start.home);
    };
    options.edges = 1e-6, options.further = 1;  // no ball is larger than the largest move is already
    const double alone = angle(0), helped = angle(4);
    EXPECT_GE(helped, 0.999 * alone);
  }
}

// A place that was not worth it was changed where another one was.
TEST(Opening, PlacesThatAreNotWorthwhileStay) {
  const Pressed start = pressed(3, 6);
  OpeningOptions options;
  options.largest_move = 1;
  options.home_sweeps = 0;
  options.worthwhile = 1e30;
  TetMesh mesh = start.mesh;
  ASSERT_TRUE(open_up(mesh, start.home, options, {}).ok());
  EXPECT_EQ(mesh.V, start.mesh.V);
  EXPECT_EQ(mesh.T, start.mesh.T);
}

TEST(Opening, WhatIsAtHomeStays) {
  const TetMesh torus = filled_torus();
  TetMesh mesh = torus;
  OpeningOptions options;
  options.largest_move = 1;
  const auto r = open_up(mesh, torus.V.topRows(torus.surface_vertices), options, {});
  ASSERT_TRUE(r.ok());
  EXPECT_TRUE(r.value().places.empty());
  EXPECT_EQ(mesh.V, torus.V);
  EXPECT_EQ(mesh.T, torus.T);
}

TEST(Opening, SameBytesOnAnyNumberOfThreads) {
  const Pressed start = pressed(6, 6);
  OpeningOptions options;
  options.largest_move = 1;
  std::vector<TetMesh> made;
  for (const int threads : {1, 2, 5}) {
    const ScopedThreads scope(threads);
    made.push_back(start.mesh);
    ASSERT_TRUE(open_up(made.back(), start.home, options, {}).ok());
  }
  for (const TetMesh& mesh : made) {
    EXPECT_EQ(mesh.V, made[0].V);
    EXPECT_EQ(mesh.T, made[0].T);
  }
}

TEST(Opening, StopsWhenAsked) {
  const Pressed start = pressed(7, 3);
  OpeningOptions options;
  options.largest_move = 1;
  std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  TetMesh mesh = start.mesh;
  const auto r = open_up(mesh, start.home, options, context);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::interrupted);
}

TEST(Opening, RefusesOptionsWithoutSense) {
  OpeningOptions options;
  EXPECT_FALSE(options.validate().ok());  // largest_move must be given
  options.largest_move = 1;
  EXPECT_TRUE(options.validate().ok());
  options.growth = 1;
  EXPECT_FALSE(options.validate().ok());
}

}  // namespace
}  // namespace overtet
