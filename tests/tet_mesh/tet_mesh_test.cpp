#include "src/tet_mesh/tet_mesh.h"

#include <gtest/gtest.h>

#include "tests/support/models.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

TEST(TetMeshStage, PostconditionsHold) {
  for (const Surface& s : {test::box_surface(1, 1, 1), test::sphere_surface(2),
                           test::torus_surface(20, 8, 2, .4), test::sphere_with_cavity()})
    for (const bool quality : {true, false})
      for (const bool splits : {true, false}) {
        TetMeshOptions options;
        options.quality = quality;
        options.pre_splits = splits;
        const auto r = tet_mesh(s, options, {});
        ASSERT_TRUE(r.ok()) << r.error().message;
        const auto status = check_postconditions(r.value(), s, options);
        EXPECT_TRUE(status.ok()) << status.error().message;
        const auto& x = r.value();
        if (splits && !quality) {
          EXPECT_GT(x.edges_split + x.faces_split + x.tets_split, 0);
        }
        if (!splits) {
          EXPECT_EQ(0, x.edges_split + x.faces_split + x.tets_split);
        }
      }
}

TEST(TetMeshStage, PostconditionsNoticeDamage) {
  const Surface s = test::sphere_surface(1);
  const auto r = tet_mesh(s, {}, {});
  ASSERT_TRUE(r.ok());
  const auto broken = [&](auto&& damage) {
    TetMeshResult x = r.value();
    damage(x.mesh);
    return !check_postconditions(x, s, {}).ok();
  };
  EXPECT_TRUE(broken([](TetMesh& m) { m.V(3, 1) += 1e-15; }));
  EXPECT_TRUE(broken([](TetMesh& m) { std::swap(m.T(0, 0), m.T(0, 1)); }));
  EXPECT_TRUE(broken([](TetMesh& m) { m.T.conservativeResize(m.T.rows() - 1, 4); }));
}

TEST(TetMeshStage, AnOpenSurfaceIsAnError) {
  Surface s = test::sphere_surface(1);
  s.F.conservativeResize(s.F.rows() - 1, 3);
  const auto r = tet_mesh(s, {}, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(ErrorCode::unsolved, r.error().code);
}

TEST(TetMeshStage, ACavityOutsideIsAnError) {
  Surface bubble = test::sphere_surface(1);
  bubble.V.col(0).array() += 5;
  bubble.F.col(1).swap(bubble.F.col(2));
  const auto r = tet_mesh(test::joined(test::sphere_surface(1), bubble), {}, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(ErrorCode::unsolved, r.error().code);
}

}  // namespace
}  // namespace overtet
