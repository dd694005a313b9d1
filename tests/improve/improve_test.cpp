#include "src/improve/improve.h"

#include <gtest/gtest.h>

#include <atomic>
#include <random>

#include "src/tet_complex/local_operations.h"
#include "src/tetgen/tetgen.h"
#include "tests/support/tet_checks/tet_checks.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

TetComplex filled(const Surface& s) {
  TetgenOptions options;
  options.quality = false;
  const auto r = tetrahedralize({s.V, s.F, {}, {}}, options, {});
  EXPECT_TRUE(r.ok());
  return TetComplex(r.value().V, r.value().T);
}

// Puts vertices at a tiny height above about half of the boundary faces, several levels deep.
int squeeze(TetComplex& c, double height, int levels, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.1, 1);
  LocalOperations work(c);
  int made = 0;
  for (int level = 0; level < levels; ++level)
    for (Index t = 0, n = c.tet_capacity(); t < n; ++t) {
      if (!c.alive(t)) continue;
      for (int k = 0; k < 4; ++k) {
        if (c.neighbour(t, k) >= 0 || random() % 2) continue;
        const auto v = c.tet(t);
        Eigen::Vector3d p(0, 0, 0);
        double sum = 0;
        for (int i = 0; i < 4; ++i)
          if (i != k) {
            const double w = uniform(random);
            p += w * c.position(v[i]);
            sum += w;
          }
        p /= sum;
        made += work.split_tet(t, p + height * (c.position(v[k]) - p));
        break;
      }
    }
  return made;
}

TEST(Improve, RaisesTheSmallestAngleAndLeavesTheBoundary) {
  for (const Surface& s : {test::torus_surface(30, 12, 2, .7), test::sphere_surface(2)}) {
    TetComplex c = filled(s);
    const auto boundary = test::boundary_faces(c);
    ImproveOptions options;
    options.growth = 20;  // nothing inside yet
    const auto r = improve(c, options, {});
    ASSERT_TRUE(r.ok()) << r.error().message;
    test::expect_valid(c);
    EXPECT_EQ(boundary, test::boundary_faces(c));
    for (Index v = 0; v < s.V.rows(); ++v) ASSERT_EQ(Eigen::Vector3d(s.V.row(v)), c.position(v));
    EXPECT_GE(r.value().after.min, r.value().before.min);
    EXPECT_GT(r.value().after.min, 5);
    EXPECT_GT(r.value().after.p05, 8);
    EXPECT_EQ(c.tet_count(), r.value().after.tets);
  }
}

TEST(Improve, MeshThatPassesThroughItself) {
  const TetMesh mesh = test::bent_grid(6, 600, 0.2, 4);
  TetComplex c(mesh.V, mesh.T);
  const auto boundary = test::boundary_faces(c);
  const auto r = improve(c, {}, {});
  ASSERT_TRUE(r.ok());
  test::expect_valid(c);
  EXPECT_EQ(boundary, test::boundary_faces(c));
  EXPECT_GT(r.value().after.min, r.value().before.min);
}

TEST(Improve, ThinLayersUnderTheBoundaryGrow) {
  for (const double height : {1e-4, 1e-9}) {
    TetComplex c = filled(test::torus_surface(24, 12, 2, .7));
    ASSERT_GT(squeeze(c, height, 2, 9), 300);
    const auto boundary = test::boundary_faces(c);
    const auto r = improve(c, {}, {});
    ASSERT_TRUE(r.ok());
    test::expect_valid(c);
    EXPECT_EQ(boundary, test::boundary_faces(c));
    EXPECT_LT(r.value().before.min, 1e-2);
    EXPECT_GT(r.value().after.min, 5);
    EXPECT_GT(r.value().after.p05, 8);
  }
}

TEST(Improve, SameInputSameBytes) {
  TetComplex a = filled(test::torus_surface(24, 12, 2, .7)), b = a;
  ASSERT_TRUE(improve(a, {}, {}).ok());
  ASSERT_TRUE(improve(b, {}, {}).ok());
  const TetMesh x = a.to_mesh(0), y = b.to_mesh(0);
  EXPECT_EQ(x.T, y.T);
  EXPECT_EQ(x.V, y.V);
}

TEST(Improve, OptionsCancelAndTime) {
  TetComplex c = filled(test::sphere_surface(2));
  ImproveOptions options;
  options.target_degrees = 60;
  EXPECT_EQ(ErrorCode::usage, improve(c, options, {}).error().code);
  options = {};
  options.seconds = 0;
  const auto r = improve(c, options, {});
  ASSERT_TRUE(r.ok());
  test::expect_valid(c);
  std::atomic<bool> cancel = true;
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(ErrorCode::interrupted, improve(c, {}, context).error().code);
}

}  // namespace
}  // namespace overtet
