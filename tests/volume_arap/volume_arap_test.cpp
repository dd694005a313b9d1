#include "src/volume_arap/volume_arap.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <vector>

#include "kernels/predicates/predicates.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

TetMesh block() { return test::surface_first(test::grid_tets(4, 0.1, 7)); }

// The block's boundary turned about its axis, the more the higher; `degrees` at the top.
VertexMatrix twisted(const TetMesh& mesh, double degrees) {
  VertexMatrix V = mesh.V.topRows(mesh.surface_vertices);
  for (Eigen::Index v = 0; v < V.rows(); ++v) {
    const double angle = V(v, 2) / 4 * degrees * M_PI / 180, x = V(v, 0) - 2, y = V(v, 1) - 2;
    V(v, 0) = 2 + x * std::cos(angle) - y * std::sin(angle);
    V(v, 1) = 2 + x * std::sin(angle) + y * std::cos(angle);
  }
  return V;
}

std::vector<Index> flipped(const TetMesh& mesh) {
  std::vector<Index> list;
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    const auto at = [&](int k) { return mesh.V.data() + 3 * static_cast<std::ptrdiff_t>(mesh.T(t, k)); };
    if (orient3d(at(0), at(1), at(2), at(3)) <= 0) list.push_back(t);
  }
  return list;
}

TEST(VolumeArapStage, TheBoundaryIsAtHomeAndFlipsAreCounted) {
  const TetMesh mesh = block();
  std::size_t most = 0;
  for (const double degrees : {0.0, 20.0, 400.0}) {
    const VertexMatrix target = twisted(mesh, degrees);
    const Result<VolumeArapResult> r = volume_arap(mesh, target, {}, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    EXPECT_EQ(r.value().mesh.V.topRows(mesh.surface_vertices), target);
    EXPECT_EQ(r.value().mesh.T, mesh.T);
    EXPECT_EQ(r.value().flipped, flipped(r.value().mesh));
    if (degrees <= 20) EXPECT_TRUE(r.value().flipped.empty()) << degrees;
    most = std::max(most, r.value().flipped.size());
  }
  EXPECT_GT(most, 0u);
}

TEST(VolumeArapStage, WhatNeedNotMoveStays) {
  const TetMesh mesh = block();
  const Result<VolumeArapResult> r = volume_arap(mesh, mesh.V.topRows(mesh.surface_vertices), {}, {});
  ASSERT_TRUE(r.ok());
  EXPECT_LT((r.value().mesh.V - mesh.V).norm(), 1e-9);
  EXPECT_NEAR(r.value().energy, 0, 1e-15);
}

TEST(VolumeArapStage, SameBytesOnAnyNumberOfThreads) {
  const TetMesh mesh = block();
  RunContext one, four;
  one.threads = 1, four.threads = 4;
  const VertexMatrix target = twisted(mesh, 90);
  EXPECT_EQ(volume_arap(mesh, target, {}, one).value().mesh.V,
            volume_arap(mesh, target, {}, four).value().mesh.V);
}

TEST(VolumeArapStage, ErrorsAreValues) {
  TetMesh mesh = block();
  const VertexMatrix target = mesh.V.topRows(mesh.surface_vertices);
  EXPECT_EQ(volume_arap(mesh, target.topRows(3), {}, {}).error().code, ErrorCode::bad_input);
  EXPECT_EQ(volume_arap(mesh, target, {.iterations = 0}, {}).error().code, ErrorCode::usage);
  std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(volume_arap(mesh, target, {}, context).error().code, ErrorCode::interrupted);
  std::swap(mesh.T(0, 0), mesh.T(0, 1));
  EXPECT_EQ(volume_arap(mesh, target, {}, {}).error().code, ErrorCode::bad_input);
}

}  // namespace
}  // namespace overtet
