#include "src/cdt/manifold.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "src/cdt/tetgen.h"
#include "src/mesh/tet_complex.h"
#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

TetMatrix neighbours(const TetMesh& mesh) {
  const TetComplex c(mesh.V, mesh.T);
  TetMatrix N(mesh.T.rows(), 4);
  for (Index t = 0; t < N.rows(); ++t)
    for (int k = 0; k < 4; ++k) N(t, k) = c.neighbour(t, k);
  return N;
}

// Two blocks, one in the other's place, of which some vertices inside have the same numbers.
struct Glued {
  TetMesh mesh;
  TetMatrix N;
};
Glued glued(int n, const std::vector<Index>& same) {
  const TetMesh block = test::surface_first(test::grid_tets(n, 0, 1));
  const TetMatrix N = neighbours(block);
  const auto vertices = static_cast<Index>(block.V.rows()), tets = static_cast<Index>(block.T.rows());
  // The surfaces' vertices first, then those inside.
  const Index outside = block.surface_vertices, inside = vertices - outside;
  Glued out;
  out.mesh.surface_vertices = 2 * outside;
  out.mesh.V.resize(2 * vertices, 3);
  out.mesh.V << block.V.topRows(outside), block.V.topRows(outside), block.V.bottomRows(inside),
      block.V.bottomRows(inside);
  out.mesh.T.resize(2 * tets, 4);
  out.N.resize(2 * tets, 4);
  for (Index copy = 0; copy < 2; ++copy)
    for (Index t = 0; t < tets; ++t)
      for (int k = 0; k < 4; ++k) {
        const Index v = block.T(t, k), t_new = copy * tets + t;
        const bool shared = std::find(same.begin(), same.end(), v) != same.end();
        out.mesh.T(t_new, k) =
            v < outside ? copy * outside + v : 2 * outside + (shared ? 0 : copy) * inside + v - outside;
        out.N(t_new, k) = N(t, k) < 0 ? -1 : copy * tets + N(t, k);
      }
  return out;
}

TEST(Manifold, VerticesThatTwoLayersShareGetTwoNumbers) {
  const TetMesh block = test::surface_first(test::grid_tets(3, 0, 1));
  std::vector<Index> inside;
  for (Index v = block.surface_vertices; v < block.V.rows(); ++v) inside.push_back(v);
  for (const std::vector<Index>& same : {std::vector<Index>{inside[0]}, {inside[0], inside[1]}, inside}) {
    Glued g = glued(3, same);
    const Result<Index> count = make_manifold(g.mesh, g.N);
    ASSERT_TRUE(count.ok()) << count.error().message;
    EXPECT_EQ(count.value(), static_cast<Index>(same.size()));
    test::expect_valid(TetComplex(g.mesh.V, g.mesh.T));
    EXPECT_LT(first_not_positive(g.mesh), 0);
  }
}

TEST(Manifold, WhatIsOneStays) {
  TetMesh mesh = test::surface_first(test::grid_tets(3, 0.1, 2));
  const TetMesh before = mesh;
  EXPECT_EQ(make_manifold(mesh, neighbours(mesh)).value(), 0);
  EXPECT_EQ(mesh.T, before.T);
  EXPECT_EQ(mesh.V, before.V);
}

TEST(CoarsenAndRefine, KeepsTheBoundaryOfWhatOverlapsItself) {
  for (const double degrees : {90.0, 420.0}) {
    const TetMesh mesh = test::surface_first(test::bent_grid(3, degrees, 0.1, 5));
    ASSERT_LT(first_not_positive(mesh), 0);
    const Result<TetMesh> made = coarsen_and_refine(mesh, 2, {});
    ASSERT_TRUE(made.ok()) << made.error().message;
    EXPECT_EQ(made.value().surface_vertices, mesh.surface_vertices);
    EXPECT_EQ(made.value().V.topRows(mesh.surface_vertices), mesh.V.topRows(mesh.surface_vertices));
    EXPECT_LT(first_not_positive(made.value()), 0);
    const TetComplex complex(made.value().V, made.value().T);
    EXPECT_EQ(test::boundary_faces(complex), test::boundary_faces(TetComplex(mesh.V, mesh.T)));
    test::expect_valid(complex);
  }
}

}  // namespace
}  // namespace overtet
