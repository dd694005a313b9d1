// Patches of a tet mesh: what is cut out is a closed solid, and what is glued on again is a solid as before.
#include "src/pipeline/solid_patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>

#include "kernels/core/tet_tables.h"
#include "kernels/core/union_find.h"
#include "overtet/verification.h"
#include "src/mesh/tet_complex.h"
#include "src/mesh/topology.h"
#include "src/pipeline/pipeline.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

TetMesh mesh_of(const Surface& s) {
  MeshingOptions options;
  options.improve_degrees = 8;
  PipelineResult made = run_pipeline(s, options, {});
  EXPECT_TRUE(made.ok()) << made.report.message;
  return std::move(made.mesh);
}

// Sorted corners of a face.
using Face = std::array<Index, 3>;
Face face_of(const TetMatrix& T, Index t, int k) {
  Face f{T(t, kTetFace[k][0]), T(t, kTetFace[k][1]), T(t, kTetFace[k][2])};
  std::sort(f.begin(), f.end());
  return f;
}

// What holds of every patch, wherever its boundary is to go.
void expect_patch(const TetMesh& mesh, const VertexMatrix& target, const std::vector<Index>& away,
                  const SolidPatch& patch) {
  const Index own = patch.start.surface_vertices;
  ASSERT_TRUE(require_topology(patch.target).ok());
  ASSERT_EQ(patch.target.V.rows(), own);
  ASSERT_EQ(static_cast<std::size_t>(patch.start.V.rows()), patch.vertices.size());
  // A positive solid with these faces.
  const VerifyResult v = verify({patch.start.V.topRows(own), patch.target.F}, patch.start);
  EXPECT_TRUE(v.ok()) << v.summary();
  // Of the mesh, at home where it has one, else where it is.
  for (std::size_t i = 0; i < patch.tets.size(); ++i)
    for (int k = 0; k < 4; ++k)
      EXPECT_EQ(patch.vertices[static_cast<std::size_t>(patch.start.T(static_cast<Index>(i), k))],
                mesh.T(patch.tets[i], k));
  for (Index i = 0; i < patch.start.V.rows(); ++i) {
    const Index w = patch.vertices[static_cast<std::size_t>(i)];
    EXPECT_EQ(patch.start.V.row(i), mesh.V.row(w));
    if (i < own) {
      EXPECT_EQ(patch.target.V.row(i), w < target.rows() ? target.row(w) : mesh.V.row(w));
    }
  }
  // All that must move is in it, and the cut has none of it.
  const std::set<Index> moving(away.begin(), away.end());
  const std::set<Index> in(patch.tets.begin(), patch.tets.end());
  const TetComplex complex(mesh.V, mesh.T);
  UnionFind kept(static_cast<std::size_t>(mesh.T.rows()));
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      if (moving.count(mesh.T(t, k))) {
        EXPECT_TRUE(in.count(t)) << t;
      }
      if (const Index o = complex.neighbour(t, k); o >= 0 && !in.count(t) && !in.count(o)) kept.join(t, o);
    }
  // Nothing stays inside that hangs on no part of the surface that stays.
  std::set<Index> held;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k)
      if (complex.neighbour(t, k) < 0) held.insert(kept.root(t));
  for (Index t = 0; t < mesh.T.rows(); ++t) EXPECT_TRUE(in.count(t) || held.count(kept.root(t))) << t;
}

// The tets that were left are the same ones, and every face of the cut has a tet on both sides.
void expect_kept(const TetMesh& mesh, const SolidPatch& patch, const Draft& whole) {
  const std::set<Index> in(patch.tets.begin(), patch.tets.end());
  std::map<Face, int> tets_at;
  for (Index t = 0; t < whole.mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) ++tets_at[face_of(whole.mesh.T, t, k)];
  Index made = 0;
  const TetComplex complex(mesh.V, mesh.T);
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    if (in.count(t)) continue;
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(whole.mesh.V.row(whole.mesh.T(made, k)), mesh.V.row(mesh.T(t, k)));
      if (const Index o = complex.neighbour(t, k); o >= 0 && in.count(o)) {
        EXPECT_EQ(tets_at[face_of(whole.mesh.T, made, k)], 2);
      }
    }
    ++made;
  }
  EXPECT_EQ(whole.mesh.T.rows(), mesh.T.rows());
  EXPECT_GE(whole.placed, 0);
  EXPECT_LE(whole.mesh.surface_vertices + whole.placed, whole.mesh.V.rows());
}

TEST(SolidPatch, RandomCutsAreGluedToTheSameSolid) {
  const std::uint32_t seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (const Surface& s : {test::curled_worm(400, 10), test::slab(2), test::sphere_with_cavity(1)}) {
    const TetMesh mesh = mesh_of(s);
    for (int round = 0; round < 6; ++round) {
      // A few vertices, apart or side by side, that have moved by a hair: how the tets lie stays.
      VertexMatrix target = s.V;
      std::vector<Index> away;
      const auto count = std::uniform_int_distribution<int>(1, 12)(random);
      for (int i = 0; i < count; ++i)
        away.push_back(std::uniform_int_distribution<Index>(0, static_cast<Index>(s.V.rows()) - 1)(random));
      std::sort(away.begin(), away.end());
      away.erase(std::unique(away.begin(), away.end()), away.end());
      for (const Index v : away)
        for (int k = 0; k < 3; ++k) target(v, k) += 1e-9 * std::uniform_real_distribution<>(-1, 1)(random);
      const SolidPatch patch = solid_around(mesh, target, away, 1 + round % 3);
      expect_patch(mesh, target, away, patch);
      if (::testing::Test::HasFailure()) return;

      // Filled anew with the same tets, bent to the target.
      Draft inside{patch.start, 0};
      inside.mesh.V.topRows(patch.target.V.rows()) = patch.target.V;
      ASSERT_TRUE(verify(patch.target, inside.mesh).ok());
      const Draft whole = glued(mesh, target, patch, inside);
      expect_kept(mesh, patch, whole);
      const VerifyResult v = verify({target, s.F}, whole.mesh);
      EXPECT_TRUE(v.ok()) << v.summary();
      if (::testing::Test::HasFailure()) return;
    }
  }
}

TEST(SolidPatch, PlacedVerticesComeFirst) {
  const Surface s = test::slab(1);
  const TetMesh mesh = mesh_of(s);
  const SolidPatch patch = solid_around(mesh, s.V, {0}, 2);
  ASSERT_LT(static_cast<Index>(patch.tets.size()), mesh.T.rows());
  Draft inside{patch.start, 0};
  const Index own = patch.start.surface_vertices, all = static_cast<Index>(patch.start.V.rows());
  ASSERT_GE(all, own);
  inside.placed = all - own;
  const Draft whole = glued(mesh, s.V, patch, inside);
  for (Index i = 0; i < inside.placed; ++i)
    EXPECT_EQ(whole.mesh.V.row(s.V.rows() + i), inside.mesh.V.row(own + i));
  EXPECT_EQ(whole.mesh.surface_vertices + whole.placed, whole.mesh.V.rows());
  EXPECT_TRUE(verify(s, whole.mesh).ok());
}

// Where everything moves there is nothing to glue on: the patch is the mesh.
TEST(SolidPatch, ThePatchOfAllIsTheMesh) {
  const Surface s = test::sphere(2);
  const TetMesh mesh = mesh_of(s);
  std::vector<Index> all;
  for (Index v = 0; v < s.V.rows(); ++v) all.push_back(v);
  const SolidPatch patch = solid_around(mesh, s.V, all, 1);
  EXPECT_EQ(static_cast<Index>(patch.tets.size()), mesh.T.rows());
  EXPECT_TRUE(verify(s, glued(mesh, s.V, patch, {patch.start, 0}).mesh).ok());
}

}  // namespace
}  // namespace overtet
