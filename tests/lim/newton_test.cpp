#include "src/lim/newton.h"

#include <gtest/gtest.h>

#include <random>

#include "src/mesh/tet_complex.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

using lim_detail::Newton;

TEST(LimNewton, EveryStepIsPositiveAndGoesDown) {
  TetMesh mesh = test::surface_first(test::grid_tets(3, 0.1, 3));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.8, 0.8);
  VertexMatrix target = mesh.V.topRows(mesh.surface_vertices);
  for (Eigen::Index i = 0; i < target.size(); ++i) target.data()[i] += uniform(random);  // tangled
  Newton newton(mesh, target, 0.01, 5);
  const double alpha = 100;
  double before = newton.energies().all(alpha);
  int steps = 0;
  for (bool ok = true; ok && steps < 30; ++steps) {
    const double made = newton.step(alpha, ok);
    EXPECT_TRUE(ok);
    mesh.V = newton.positions();
    EXPECT_LT(first_not_positive(mesh), 0);
    const double after = newton.energies().all(alpha);
    if (made == 0) {
      EXPECT_EQ(after, before);
      break;
    }
    EXPECT_LT(after, before);
    before = after;
  }
  EXPECT_GT(steps, 2);
}

TEST(LimNewton, AtRestAndAtHomeThereIsNothingToGain) {
  const TetMesh mesh = test::surface_first(test::grid_tets(3, 0.1, 3));
  const VertexMatrix target = mesh.V.topRows(mesh.surface_vertices);
  Newton newton(mesh, target, 0.01, 5);
  EXPECT_NEAR(newton.energies().all(1), 0, 1e-12);
}

}  // namespace
}  // namespace overtet
