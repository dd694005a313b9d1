#include "src/volume_map/volume_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <array>
#include <atomic>
#include <cmath>
#include <optional>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "kernels/parallel/parallel.h"
#include "src/covering/wound_edges.h"
#include "src/mesh/tet_complex.h"
#include "src/tet_mesh/tet_mesh.h"
#include "src/volume_map/patch.h"
#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

// A round tube (radius 1, `around` x `along` quads, closed by two caps) whose centre line bends by
// `degrees` with radius R in its middle part, `ends` of its length going on straight on both sides. With
// R < 1 the inside of the bend passes through itself. `lift` moves one end up, out of the plane.
Surface bent_tube(int around, int along, double length, double degrees, double R, double ends, double lift) {
  std::vector<Eigen::Vector3d> V;
  std::vector<std::array<Index, 3>> F;
  const auto point = [&](double x, double r, double phi) {
    const double t = std::clamp((x - ends) / (1 - 2 * ends), 0.0, 1.0), angle = t * degrees * M_PI / 180;
    const double beyond = (x < ends ? x - ends : x > 1 - ends ? x - 1 + ends : 0) * length;
    const double radius = R + r * std::cos(phi);
    return Eigen::Vector3d(radius * std::sin(angle) + beyond * std::cos(angle),
                           radius * std::cos(angle) - beyond * std::sin(angle), r * std::sin(phi) + lift * x);
  };
  for (int i = 0; i <= along; ++i)
    for (int j = 0; j < around; ++j)
      V.push_back(point(double(i) / along, 1, 2 * M_PI * (j + 0.5 * (i % 2)) / around));
  const auto at = [&](int i, int j) { return static_cast<Index>(i * around + (j + around) % around); };
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < around; ++j) {
      if (i % 2 == 0) {
        F.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
        F.push_back({at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)});
      } else {
        F.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
        F.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
      }
    }
  for (const int end : {0, along}) {
    const Index centre = static_cast<Index>(V.size());
    V.push_back(point(double(end) / along, 0, 0));
    for (int j = 0; j < around; ++j) {
      if (end == 0) F.push_back({centre, at(0, j + 1), at(0, j)});
      if (end != 0) F.push_back({centre, at(end, j), at(end, j + 1)});
    }
  }
  Surface s;
  s.V.resize(V.size(), 3);
  s.F.resize(F.size(), 3);
  for (std::size_t v = 0; v < V.size(); ++v) s.V.row(v) = V[v];
  for (std::size_t f = 0; f < F.size(); ++f) s.F.row(f) << F[f][0], F[f][1], F[f][2];
  // Outward: positive volume.
  double volume = 0;
  for (const auto& f : F) volume += V[f[0]].dot(V[f[1]].cross(V[f[2]]));
  if (volume < 0) s.F.col(1).swap(s.F.col(2));
  return s;
}

struct Pair {
  Surface embedded, target;
  TetMesh mesh;
  std::vector<WoundEdge> wound;
  std::size_t crossings = 0, hinges = 0;
};

Pair make_pair(const Surface& embedded, const Surface& target) {
  Pair p{embedded, target, {}, {}, 0, 0};
  const auto topology = require_topology(target);
  EXPECT_TRUE(topology.ok());
  EXPECT_TRUE(find_self_intersections(embedded.V, embedded.F).empty());
  const auto pairs = find_self_intersections(target.V, target.F);
  p.crossings = pairs.size();
  const TriangleBvh bvh(target.V, target.F);
  const auto hinges = find_hinges(target, topology.value(), bvh, pairs);
  p.hinges = hinges.size();
  const auto wound = assign_wound_edges(target, topology.value(), bvh, hinges,
                                        find_pierced_edges(target, topology.value(), pairs), {});
  EXPECT_TRUE(wound.ok());
  p.wound = wound.value().edges;
  const auto filled = tet_mesh(embedded, {}, {});
  EXPECT_TRUE(filled.ok());
  p.mesh = filled.value().mesh;
  return p;
}

void expect_solved(const Pair& p, const Result<VolumeMapResult>& r) {
  ASSERT_TRUE(r.ok()) << r.error().message;
  const auto status = check_postconditions(r.value(), p.target.V);
  EXPECT_TRUE(status.ok()) << status.error().message;
  const TetComplex before(p.mesh.V, p.mesh.T), after(r.value().mesh.V, r.value().mesh.T);
  test::expect_valid(after);
  EXPECT_EQ(test::boundary_faces(before), test::boundary_faces(after));
}

TEST(VolumeMap, NothingToDoChangesNothing) {
  const Surface s = test::torus_surface(16, 8, 2, .6);
  const auto filled = tet_mesh(s, {}, {});
  ASSERT_TRUE(filled.ok());
  const auto r = volume_map(filled.value().mesh, s.V, {}, {}, {});
  ASSERT_TRUE(r.ok());
  EXPECT_EQ(filled.value().mesh.T, r.value().mesh.T);
  EXPECT_EQ(filled.value().mesh.V, r.value().mesh.V);
}

TEST(VolumeMap, TubeWhoseEndsPassThroughEachOther) {
  const Pair p = make_pair(bent_tube(10, 40, 20, 250, 2.5, 0, 0.2), bent_tube(10, 40, 20, 400, 2.5, 0, 0.2));
  ASSERT_GT(p.crossings, 10u);
  const auto r = volume_map(p.mesh, p.target.V, p.wound, {}, {});
  expect_solved(p, r);
  const auto again = volume_map(p.mesh, p.target.V, p.wound, {}, {});
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(r.value().mesh.T, again.value().mesh.T);
  EXPECT_EQ(r.value().mesh.V, again.value().mesh.V);
}

// Turned inside out there is no map; the answer is an error that names a place, in bounded time.
TEST(VolumeMap, TheImpossibleIsAnError) {
  const Surface s = test::sphere_surface(1);
  const auto filled = tet_mesh(s, {}, {});
  ASSERT_TRUE(filled.ok());
  VolumeMapOptions options;
  options.rounds = 30;
  const auto r = volume_map(filled.value().mesh, -s.V, {}, options, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(ErrorCode::unsolved, r.error().code);
  EXPECT_NE(std::string::npos, r.error().message.find("vertex")) << r.error().message;
}

// The same where coming near is enough: a ball of which one side is pushed in until it sticks out inside out
// on the other one.
TEST(VolumeMap, WhatCannotBeReachedIsApproached) {
  const Surface s = test::sphere_surface(2);
  const auto filled = tet_mesh(s, {}, {});
  ASSERT_TRUE(filled.ok());
  VertexMatrix target = s.V;
  for (Index v = 0; v < target.rows(); ++v)
    target(v, 2) -= 2.2 * std::exp(-8 * (target.row(v) - Eigen::RowVector3d(0, 0, 1)).squaredNorm());
  VolumeMapOptions options;
  options.refinements = 0;
  EXPECT_FALSE(volume_map(filled.value().mesh, target, {}, options, {}).ok());
  double least = 1e300;
  for (const double largest : {1e300, 0.3}) {
    SCOPED_TRACE(largest);
    options.largest_move = largest;
    const auto r = volume_map(filled.value().mesh, target, {}, options, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    const VolumeMapResult& x = r.value();
    const TetComplex before(filled.value().mesh.V, filled.value().mesh.T), after(x.mesh.V, x.mesh.T);
    test::expect_valid(after);
    EXPECT_EQ(test::boundary_faces(before), test::boundary_faces(after));
    EXPECT_FALSE(x.away.empty());
    EXPECT_LT(x.away.size(), static_cast<std::size_t>(s.V.rows()) / 3);
    double farthest = 0;
    for (const Index v : x.away) {
      EXPECT_NE(x.mesh.V.row(v), target.row(v));
      farthest = std::max(farthest, (x.mesh.V.row(v) - target.row(v)).norm());
    }
    EXPECT_DOUBLE_EQ(farthest, x.farthest);
    EXPECT_TRUE(check_postconditions(x, target).ok());  // all others are at their places
    EXPECT_LE(farthest, least);
    least = farthest;
  }
}

TEST(VolumeMap, OptionsCancelAndPostconditions) {
  const Surface s = test::sphere_surface(1);
  const auto filled = tet_mesh(s, {}, {});
  ASSERT_TRUE(filled.ok());
  VolumeMapOptions options;
  options.pull_growth = 1;
  EXPECT_EQ(ErrorCode::usage, volume_map(filled.value().mesh, s.V, {}, options, {}).error().code);
  EXPECT_EQ(ErrorCode::usage, volume_map(filled.value().mesh, s.V.topRows(3), {}, {}, {}).error().code);
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(ErrorCode::interrupted, volume_map(filled.value().mesh, 2 * s.V, {}, {}, context).error().code);

  auto r = volume_map(filled.value().mesh, s.V, {}, {}, {});
  ASSERT_TRUE(r.ok());
  EXPECT_TRUE(check_postconditions(r.value(), s.V).ok());
  EXPECT_FALSE(check_postconditions(r.value(), 2 * s.V).ok());
  std::swap(r.value().mesh.T(0, 0), r.value().mesh.T(0, 1));
  EXPECT_FALSE(check_postconditions(r.value(), s.V).ok());
}

// The work that patches share out, and where it ends, does not depend on who does it.
TEST(VolumeMap, ThreadsAndWork) {
  const Pair p = make_pair(bent_tube(10, 40, 20, 250, 2.5, 0, 0.2), bent_tube(10, 40, 20, 400, 2.5, 0, 0.2));
  VolumeMapOptions options;
  const auto whole = volume_map(p.mesh, p.target.V, p.wound, options, {});
  ASSERT_TRUE(whole.ok());
  EXPECT_GT(whole.value().work, 0);
  EXPECT_GT(whole.value().newton_steps, 0);
  options.work = whole.value().work / 2;
  options.largest_move = 1;
  std::optional<VolumeMapResult> first;
  for (const int threads : {1, 2, 3}) {
    const ScopedThreads scope(threads);
    const auto full = volume_map(p.mesh, p.target.V, p.wound, {}, {});
    ASSERT_TRUE(full.ok());
    EXPECT_EQ(whole.value().mesh.V, full.value().mesh.V);
    EXPECT_EQ(whole.value().mesh.T, full.value().mesh.T);
    const auto half = volume_map(p.mesh, p.target.V, p.wound, options, {});
    ASSERT_TRUE(half.ok());
    EXPECT_LT(half.value().rounds.size(), whole.value().rounds.size());
    EXPECT_FALSE(half.value().cut_by_time);
    if (!first) first = half.value();
    EXPECT_EQ(first->mesh.V, half.value().mesh.V);
    EXPECT_EQ(first->mesh.T, half.value().mesh.T);
  }
}

TEST(VolumeMap, PatchStepsGoDownAndStayPositive) {
  using namespace volume_map_detail;
  const TetMesh mesh = test::grid_tets(4, 0.2, 3);
  TetComplex c(mesh.V, mesh.T);
  // All boundary vertices stay but those of one side, which are pulled outwards unevenly.
  std::vector<Index> order;
  for (const bool on : {true, false})
    for (Index v = 0; v < c.vertex_count(); ++v)
      if (c.on_boundary(v) == on) order.push_back(v);
  std::vector<Index> number(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) number[order[i]] = static_cast<Index>(i);
  TetMesh sorted = mesh;
  for (std::size_t i = 0; i < order.size(); ++i) sorted.V.row(i) = mesh.V.row(order[i]);
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) sorted.T(t, k) = number[mesh.T(t, k)];
  const Index nb = static_cast<Index>(order.size()) - 27;
  TetComplex grid(sorted.V, sorted.T);
  VertexMatrix target = sorted.V.topRows(nb);
  std::vector<char> may_move(nb, 0);
  std::vector<Index> seeds;
  for (Index v = 0; v < nb; ++v)
    if (target(v, 2) == 4) {
      target.row(v) +=
          Eigen::RowVector3d(0.3 * target(v, 1), 0.5 * std::sin(3 * target(v, 0)), 1 + target(v, 0) / 4);
      may_move[v] = 1;
      seeds.push_back(v);
    }
  const std::vector<double> length(order.size(), 1);
  auto patches = grow_patches(grid, nb, seeds, 3, 0, may_move);
  ASSERT_EQ(1u, patches.size());
  EXPECT_EQ(25 + 27, static_cast<int>(patches[0].free.size()));
  // The straight interior edges make a turn, the box's own edges a quarter of one.
  for (const auto& f : grid.boundary())
    for (int k = 0; k < 3; ++k) {
      const double angle = interior_angle(grid, f[k], f[(k + 1) % 3]);
      EXPECT_TRUE(std::fabs(angle - M_PI) < 1e-9 || std::fabs(angle - M_PI / 2) < 1e-9);
    }
  PatchForces forces;
  forces.pull = 10;
  forces.angle_weight = 1;
  patches[0].goals.push_back({seeds[0], seeds[1], 2.0, edge_ring(grid, seeds[0], seeds[1])});
  PatchNewton newton(grid, patches[0], target, length);
  double energy = newton.energy(forces);
  int steps = 0;
  while (steps < 30 && newton.step(forces)) {
    const std::vector<Eigen::Vector3d> positions = newton.positions();
    for (std::size_t i = 0; i < positions.size(); ++i) grid.move(patches[0].free[i], positions[i]);
    const double now = newton.energy(forces);
    ASSERT_LE(now, energy);
    energy = now;
    test::expect_valid(grid);
    ++steps;
  }
  EXPECT_GT(steps, 3);

  // With a reach every step still descends, and the farthest ends nearer.
  const TetComplex start(sorted.V, sorted.T);
  patches[0].goals.clear();
  const auto farthest = [&](double reach) {
    PatchForces pull;
    pull.pull = 0.1;
    pull.reach = reach;
    PatchNewton steps_back(start, patches[0], target, length);
    double before = steps_back.energy(pull);
    for (int i = 0; i < 60 && steps_back.step(pull); ++i) {
      EXPECT_LE(steps_back.energy(pull), before);
      before = steps_back.energy(pull);
    }
    const std::vector<Eigen::Vector3d> to = steps_back.positions();
    double most = 0;
    for (std::size_t i = 0; i < to.size(); ++i)
      if (const Index v = patches[0].free[i]; v < nb)
        most = std::max(most, (to[i] - target.row(v).transpose()).norm());
    return most;
  };
  EXPECT_LT(farthest(0.2), 0.9 * farthest(0));
}

// What winds an edge: its angle, summed over its tets, is driven past a full turn.
TEST(VolumeMap, AnglesAreDriven) {
  using namespace volume_map_detail;
  const Surface s = bent_tube(8, 12, 8, 10, 4, 0.1, 0);
  const auto filled = tet_mesh(s, {}, {});
  ASSERT_TRUE(filled.ok());
  TetComplex c(filled.value().mesh.V, filled.value().mesh.T);
  const std::vector<double> length(c.vertex_count(), 0.7);
  const Index middle = 6 * 8;  // a vertex half way along, and the next one around
  std::vector<char> may_move(s.V.rows(), 0);
  std::vector<Index> seeds;
  for (Index v = 3 * 8; v < 10 * 8; ++v) {
    may_move[v] = 1;
    seeds.push_back(v);
  }
  auto patches = grow_patches(c, static_cast<Index>(s.V.rows()), seeds, 3, 0, may_move);
  ASSERT_EQ(1u, patches.size());
  ASSERT_TRUE(c.has_edge(middle, middle + 1));
  const double goal = 7;  // more than a turn: over itself
  ASSERT_LT(interior_angle(c, middle, middle + 1), 5);
  patches[0].goals.push_back({middle, middle + 1, goal, edge_ring(c, middle, middle + 1)});
  PatchForces forces;
  forces.pull = 0.01;
  forces.angle_weight = 1000;
  PatchNewton newton(c, patches[0], s.V, length);
  for (int step = 0; step < 60 && newton.step(forces);) ++step;
  const std::vector<Eigen::Vector3d> positions = newton.positions();
  for (std::size_t i = 0; i < positions.size(); ++i) c.move(patches[0].free[i], positions[i]);
  test::expect_valid(c);
  EXPECT_NEAR(goal, interior_angle(c, middle, middle + 1), 0.5);
}

}  // namespace
}  // namespace overtet
