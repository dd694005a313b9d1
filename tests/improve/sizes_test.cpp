// Sizes, coarse meshes, overfull ones, and distinct points.
#include "src/improve/sizes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "kernels/core/tet_tables.h"
#include "kernels/near_points/near_points.h"
#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/cdt/tetgen.h"
#include "src/improve/improve.h"
#include "src/improve/set_apart.h"
#include "src/mesh/local_operations.h"
#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

TetMesh tets_inside(const Surface& s) {
  const auto r = tetrahedralize({s.V, s.F, {}, {}}, TetgenOptions{}, {});
  EXPECT_TRUE(r.ok());
  return {r.value().V, r.value().T, static_cast<Index>(s.V.rows())};
}

test::FaceSet faces_of(const TetMesh& mesh) { return test::boundary_faces(TetComplex(mesh.V, mesh.T)); }

void expect_same_boundary(const TetMesh& before, const TetMesh& after) {
  EXPECT_EQ(faces_of(before), faces_of(after));
  EXPECT_EQ(before.V.topRows(before.surface_vertices), after.V.topRows(after.surface_vertices));
  test::expect_valid(TetComplex(after.V, after.T));
}

// The longest edge that is not one of the boundary.
double longest_inside(const TetMesh& mesh) {
  const TetComplex c(mesh.V, mesh.T);
  double longest = 0;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (const auto& [i, j] : kTetEdge) {
      const Index a = mesh.T(t, i), b = mesh.T(t, j);
      const double length = (mesh.V.row(a) - mesh.V.row(b)).norm();
      if (length > longest && !c.edge_on_boundary(a, b)) longest = length;
    }
  return longest;
}

double largest_volume(const TetMesh& mesh) {
  double largest = 0;
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    const auto side = [&](int k) -> Eigen::Vector3d {
      return mesh.V.row(mesh.T(t, k)) - mesh.V.row(mesh.T(t, 0));
    };
    largest = std::max(largest, side(1).cross(side(2)).dot(side(3)) / 6);
  }
  return largest;
}

TEST(Sizes, EdgesAndVolumesAreAsSmallAsAskedWhereTheBoundaryAllows) {
  const TetMesh start = tets_inside(test::torus_surface(60, 24, 2, .7));  // edges of .1 to .34
  for (const std::int64_t tets_per_part : {40000, 1000}) {
    ImproveOptions options;
    options.tets_per_part = tets_per_part;
    options.sizes.max_edge = 0.4;
    TetMesh mesh = start;
    const auto r = improve(mesh, options, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    expect_same_boundary(start, mesh);
    EXPECT_EQ(0, r.value().too_large);
    EXPECT_EQ(0, r.value().fixed_too_long);
    EXPECT_LE(longest_inside(mesh), 0.4);
    EXPECT_GT(r.value().after.min, 8);

    options.sizes = {};
    options.sizes.max_volume = 5e-3;  // that of a regular tet on the longest edge of the boundary is less
    mesh = start;
    const auto by_volume = improve(mesh, options, {});
    ASSERT_TRUE(by_volume.ok());
    expect_same_boundary(start, mesh);
    EXPECT_EQ(0, by_volume.value().too_large);
    EXPECT_LE(largest_volume(mesh), 5e-3 * (1 + 1e-9));
    EXPECT_GT(by_volume.value().after.min, 8);
  }
}

TEST(Sizes, LeastAnglesAreAsGoodAsWithoutThem) {
  const TetMesh start = tets_inside(test::torus_surface(60, 24, 2, .7));
  ImproveOptions options;
  TetMesh plain = start;
  const double without = improve(plain, options, {}).value().after.min;
  for (const double edge : {0.4, 0.3, 0.2}) {
    SCOPED_TRACE(edge);
    TetMesh mesh = start;
    options.sizes.max_edge = edge;
    const auto r = improve(mesh, options, {});
    ASSERT_TRUE(r.ok());
    EXPECT_EQ(0, r.value().too_large);
    EXPECT_GE(r.value().after.min, std::min(options.target_degrees, without) - 0.01);
  }
}

// Edges were split beside longer ones: ever more became too long, around vertices with thousands of tets.
TEST(Sizes, SplitsDidNotEndWhereTheBoundaryIsCoarser) {
  TetMesh mesh = tets_inside(test::torus_surface(60, 24, 2, .7));
  ImproveOptions options;
  options.target_degrees = 5;
  options.sizes.max_edge = 0.12;
  ASSERT_TRUE(improve(mesh, options, {}).ok());
  std::vector<int> tets(static_cast<std::size_t>(mesh.V.rows()), 0);
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) ++tets[static_cast<std::size_t>(mesh.T(t, k))];
  EXPECT_LT(*std::max_element(tets.begin(), tets.end()), 500);
  EXPECT_LT(mesh.T.rows(), 250000);
}

TEST(Sizes, InTheUsersUnit) {
  const TetMesh start = tets_inside(test::torus_surface(60, 24, 2, .7));
  TetMesh one = start, half = start;
  half.V *= 0.5;
  ImproveOptions options;
  options.sizes.max_edge = 0.3;
  ASSERT_TRUE(improve(one, options, {}).ok());
  options.sizes.unit.setConstant(2);
  ASSERT_TRUE(improve(half, options, {}).ok());
  EXPECT_EQ(one.T, half.T);
  EXPECT_EQ(one.V, 2 * half.V);
}

TEST(Sizes, GradedFromOnePlaceOfTheSurface) {
  const Surface s = test::sphere_surface(4);
  const TetMesh start = tets_inside(s);
  ImproveOptions options;
  for (Index v = 0; v < s.V.rows(); ++v)
    options.sizes.at_surface.push_back(s.V(v, 2) > 0.9 ? 0.12 : std::numeric_limits<double>::infinity());
  TetMesh mesh = start;
  const auto r = improve(mesh, options, {});
  ASSERT_TRUE(r.ok());
  expect_same_boundary(start, mesh);
  EXPECT_EQ(0, r.value().too_large);
  double top = 0, bottom = 0;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (const auto& [i, j] : kTetEdge) {
      const Eigen::RowVector3d a = mesh.V.row(mesh.T(t, i)), b = mesh.V.row(mesh.T(t, j));
      double& longest = a[2] + b[2] > 1.6 ? top : bottom;
      longest = std::max(longest, (a - b).norm());
    }
  EXPECT_LT(top, 0.3);
  EXPECT_GT(bottom, 2 * top);
}

TEST(Sizes, AMeshThatPassesThroughItselfGetsThemInEveryLayer) {
  TetMesh start = test::bent_grid(4, 600, 0.2, 3);
  start.surface_vertices = static_cast<Index>(start.V.rows());  // all keep their numbers
  double longest = longest_inside(start);
  ImproveOptions options;
  options.sizes.max_edge = 0.6 * longest;
  TetMesh first;
  for (const int threads : {1, 3}) {
    const ScopedThreads scope(threads);
    options.tets_per_part = 500;
    TetMesh mesh = start;
    const auto r = improve(mesh, options, {});
    ASSERT_TRUE(r.ok());
    EXPECT_EQ(faces_of(start), faces_of(mesh));
    test::expect_valid(TetComplex(mesh.V, mesh.T));
    EXPECT_GT(mesh.T.rows(), start.T.rows());
    if (threads == 1) first = mesh;
    EXPECT_EQ(first.T, mesh.T);
    EXPECT_EQ(first.V, mesh.V);
  }
}

TEST(Sizes, WhatTheBoundaryForbidsIsCounted) {
  const TetMesh start = tets_inside(test::box_surface(1, 1, 1));
  ImproveOptions options;
  options.sizes.max_edge = 0.2;
  TetMesh mesh = start;
  const auto r = improve(mesh, options, {});
  ASSERT_TRUE(r.ok());
  expect_same_boundary(start, mesh);
  EXPECT_EQ(18, r.value().fixed_too_long);
  EXPECT_GT(r.value().after.min, 5) << "no thin tets for sizes out of reach";

  options.sizes.max_edge = -1;
  EXPECT_EQ(ErrorCode::usage, improve(mesh, options, {}).error().code);
  // Towards the middle of a sphere the boundary allows more and more, until it would be too many.
  options.sizes.max_edge = 1e-9;
  mesh = tets_inside(test::sphere_surface(3));
  EXPECT_EQ(ErrorCode::usage, improve(mesh, options, {}).error().code);
}

TEST(Coarse, FewerVerticesAndStillTheTargetAngle) {
  const TetMesh start = tets_inside(test::sphere_surface(3));
  ImproveOptions options;
  options.sizes.max_edge = 0.15;
  TetMesh fine = start;
  ASSERT_TRUE(improve(fine, options, {}).ok());
  options.sizes = {};
  options.coarse = true;
  options.tets_per_part = 2000;
  TetMesh coarse = fine;
  const auto r = improve(coarse, options, {});
  ASSERT_TRUE(r.ok());
  expect_same_boundary(start, coarse);
  EXPECT_GT(r.value().coarsened, 0);
  EXPECT_LT(2 * coarse.T.rows(), fine.T.rows());
  EXPECT_GE(r.value().after.min, std::min(16.99, r.value().before.min));
}

TEST(Thin, AnOverfullMeshIsThinnedOut) {
  const TetMesh start = tets_inside(test::box_surface(1, 1, 1));
  TetComplex c(start.V, start.T);
  LocalOperations work(c);
  std::mt19937 random(1);
  for (int i = 0; i < 3000; ++i) {
    const Index t = static_cast<Index>(random() % static_cast<unsigned>(c.tet_capacity()));
    if (!c.alive(t)) continue;
    const auto v = c.tet(t);
    work.split_tet(t,
                   0.97 * c.position(v[0]) + 0.01 * (c.position(v[1]) + c.position(v[2]) + c.position(v[3])));
  }
  TetMesh mesh = c.to_mesh(start.surface_vertices);
  ASSERT_GT(mesh.T.rows(), 5000);
  const auto r = improve(mesh, {}, {});
  ASSERT_TRUE(r.ok());
  expect_same_boundary(start, mesh);
  EXPECT_GT(r.value().thinned, 1500);
  EXPECT_LT(mesh.T.rows(), 200);
  EXPECT_GT(r.value().after.min, 15);
}

TEST(SetApart, VerticesOfTwoLayersStepAsideAndNoneElse) {
  // Twice the same mesh, in one place.
  const TetMesh once = [] {
    TetMesh mesh = tets_inside(test::sphere_surface(2));
    ImproveOptions options;
    options.sizes.max_edge = 0.3;
    EXPECT_TRUE(improve(mesh, options, {}).ok());
    return mesh;
  }();
  const Index s = once.surface_vertices, inside = static_cast<Index>(once.V.rows()) - s;
  ASSERT_GT(inside, 20);
  TetMesh twice;
  twice.surface_vertices = 2 * s;
  twice.V.resize(2 * once.V.rows(), 3);
  twice.V << once.V.topRows(s), once.V.topRows(s), once.V.bottomRows(inside), once.V.bottomRows(inside);
  twice.T.resize(2 * once.T.rows(), 4);
  for (int copy = 0; copy < 2; ++copy)
    for (Index t = 0; t < once.T.rows(); ++t)
      for (int k = 0; k < 4; ++k) {
        const Index v = once.T(t, k);
        twice.T(copy * once.T.rows() + t, k) = v < s ? v + copy * s : v + s + copy * inside;
      }
  TetMesh mesh = twice;
  const SetApartResult r = set_apart(mesh, {});
  EXPECT_EQ(inside, r.moved);
  EXPECT_EQ(0, r.stuck);
  EXPECT_EQ(2 * s, r.forced);
  EXPECT_EQ(twice.V.topRows(2 * s + inside), mesh.V.topRows(2 * s + inside));
  EXPECT_EQ(-1, first_not_positive(mesh));
  EXPECT_EQ(2 * s, NearPoints(mesh.V).closest().coincident);
  EXPECT_GT(dihedral_statistics(mesh.V, mesh.T).min, 0.99 * dihedral_statistics(once.V, once.T).min);
  const VertexMatrix V = mesh.V;
  const SetApartResult again = set_apart(mesh, {});
  EXPECT_EQ(0, again.moved);
  EXPECT_EQ(V, mesh.V);
}

}  // namespace
}  // namespace overtet
