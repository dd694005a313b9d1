#include "src/lim/lim.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "src/mesh/tet_complex.h"
#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

TetMesh block() { return test::surface_first(test::grid_tets(4, 0.1, 7)); }

VertexMatrix sheared(const TetMesh& mesh, double by) {
  VertexMatrix V = mesh.V.topRows(mesh.surface_vertices);
  for (Eigen::Index v = 0; v < V.rows(); ++v) V(v, 0) += by * std::sin(V(v, 1) + V(v, 2));
  return V;
}

// One corner of the boundary pushed through the opposite side: no mesh can follow.
VertexMatrix pierced(const TetMesh& mesh) {
  VertexMatrix V = mesh.V.topRows(mesh.surface_vertices);
  V.row(0) << 9, 9, 9;
  return V;
}

TEST(Lim, ReachesWhatCanBeReachedWithoutAnEdgeOfTwoTurns) {
  const TetMesh mesh = block();
  for (const double by : {0.0, 0.3, 1.0}) {
    const VertexMatrix target = sheared(mesh, by);
    const Result<LimResult> r = lim(mesh, target, {}, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    ASSERT_EQ(r.value().end, LimResult::End::reached) << by;
    EXPECT_EQ(r.value().mesh.V.topRows(mesh.surface_vertices), target);
    EXPECT_LT(first_not_positive(r.value().mesh), 0);
    EXPECT_TRUE(r.value().away.empty());
    if (!r.value().jumped) test::expect_valid(TetComplex(r.value().mesh.V, r.value().mesh.T));
  }
}

TEST(Lim, SaysWhoIsAwayWhereItStalls) {
  const TetMesh mesh = block();
  LimOptions options;
  options.remesh_every = 0;
  const VertexMatrix target = pierced(mesh);
  const Result<LimResult> r = lim(mesh, target, options, {});
  ASSERT_TRUE(r.ok()) << r.error().message;
  EXPECT_NE(r.value().end, LimResult::End::reached);
  ASSERT_FALSE(r.value().away.empty());
  EXPECT_LT(first_not_positive(r.value().mesh), 0);
  test::expect_valid(TetComplex(r.value().mesh.V, r.value().mesh.T));
  std::size_t next = 0;
  for (Index v = 0; v < target.rows(); ++v)
    if (r.value().mesh.V.row(v) != target.row(v)) {
      ASSERT_LT(next, r.value().away.size());
      EXPECT_EQ(r.value().away[next++], v);
    }
  EXPECT_EQ(next, r.value().away.size());
}

// Remeshing keeps the boundary, and what it makes is positive and a manifold.
TEST(Lim, RemeshesWhereItDoesNotGetOn) {
  const TetMesh mesh = block();
  LimOptions options;
  options.remesh_every = 5;
  options.remeshes = 2;
  const Result<LimResult> r = lim(mesh, pierced(mesh), options, {});
  ASSERT_TRUE(r.ok()) << r.error().message;
  EXPECT_FALSE(r.value().remeshes.empty());
  EXPECT_EQ(test::boundary_faces(TetComplex(r.value().mesh.V, r.value().mesh.T)),
            test::boundary_faces(TetComplex(mesh.V, mesh.T)));
  EXPECT_LT(first_not_positive(r.value().mesh), 0);
}

TEST(Lim, SameBytesOnAnyNumberOfThreads) {
  const TetMesh mesh = block();
  RunContext one, four;
  one.threads = 1, four.threads = 4;
  const VertexMatrix target = sheared(mesh, 1.5);
  const LimResult a = lim(mesh, target, {}, one).value(), b = lim(mesh, target, {}, four).value();
  EXPECT_EQ(a.mesh.V, b.mesh.V);
  EXPECT_EQ(a.mesh.T, b.mesh.T);
}

TEST(Lim, ErrorsAreValues) {
  TetMesh mesh = block();
  const VertexMatrix target = sheared(mesh, 0.5);
  EXPECT_EQ(lim(mesh, target.topRows(3), {}, {}).error().code, ErrorCode::bad_input);
  LimOptions options;
  options.barrier = 0;
  EXPECT_EQ(lim(mesh, target, options, {}).error().code, ErrorCode::usage);
  std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(lim(mesh, pierced(mesh), {}, context).error().code, ErrorCode::interrupted);
  std::swap(mesh.T(0, 0), mesh.T(0, 1));
  EXPECT_EQ(lim(mesh, target, {}, {}).error().code, ErrorCode::bad_input);
}

}  // namespace
}  // namespace overtet
