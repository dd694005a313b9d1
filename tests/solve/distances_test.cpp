// Distances inside solids, by the heat method.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "overtet/meshing.h"
#include "overtet/solve.h"
#include "tests/support/flow_surfaces.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

// From the middle of a cube.
double mean_error(int n) {
  TetMesh m = test::grid_tets(n, 0.1, 3);
  m.V /= m.V.maxCoeff();
  Index middle = 0;
  const Eigen::RowVector3d centre(0.5, 0.5, 0.5);
  for (Index v = 0; v < m.V.rows(); ++v)
    if ((m.V.row(v) - centre).norm() < (m.V.row(middle) - centre).norm()) middle = v;
  const Result<Distances> d = Distances::prepare(m);
  EXPECT_TRUE(d.ok()) << d.error().message;
  const Index sources[] = {middle};
  const Result<Eigen::VectorXd> found = d.value().from(sources);
  EXPECT_TRUE(found.ok());
  double sum = 0;
  for (Index v = 0; v < m.V.rows(); ++v)
    sum += std::abs(found.value()[v] - (m.V.row(v) - m.V.row(middle)).norm());
  return sum / static_cast<double>(m.V.rows());
}

TEST(Distances, ConvergeInAConvexSolid) {
  const double coarse = mean_error(6), fine = mean_error(12), finer = mean_error(20);
  EXPECT_LT(fine, 0.75 * coarse);
  EXPECT_LT(finer, 0.8 * fine);
  EXPECT_LT(finer, 0.025);
}

// A bar bent by more than a turn overlaps itself, and is as long as before.
TEST(Distances, OverlapIsNoShortcut) {
  const TetMesh bent = test::bent_grid(6, 400, 0, 1);
  const Result<Distances> d = Distances::prepare(bent);
  ASSERT_TRUE(d.ok()) << d.error().message;
  // The two ends: the vertices that are farthest from each other inside.
  const Index sources[] = {0};
  const Result<Eigen::VectorXd> from = d.value().from(sources);
  ASSERT_TRUE(from.ok());
  Index far = 0;
  from.value().maxCoeff(&far);
  const double beeline = (bent.V.row(far) - bent.V.row(0)).norm();
  EXPECT_GT(from.value()[far], 2 * beeline);
  EXPECT_EQ(from.value()[0], 0);
}

TEST(Distances, OtherComponentsAreOutOfReach) {
  const TetMesh one = test::grid_tets(2, 0, 1);
  TetMesh two = one;
  two.V.conservativeResize(2 * one.V.rows(), 3);
  two.V.bottomRows(one.V.rows()) = one.V;  // in the same place
  two.T.conservativeResize(2 * one.T.rows(), 4);
  two.T.bottomRows(one.T.rows()) = one.T.array() + static_cast<Index>(one.V.rows());
  const Result<Distances> d = Distances::prepare(two);
  ASSERT_TRUE(d.ok()) << d.error().message;
  const Index sources[] = {0, 1};
  const Result<Eigen::VectorXd> from = d.value().from(sources);
  ASSERT_TRUE(from.ok());
  EXPECT_TRUE(from.value().head(one.V.rows()).allFinite());
  EXPECT_EQ(from.value()[0], 0);
  EXPECT_EQ(from.value()[1], 0);
  for (Eigen::Index v = one.V.rows(); v < two.V.rows(); ++v) EXPECT_TRUE(std::isinf(from.value()[v]));
  EXPECT_EQ(d.value().from({}).error().code, ErrorCode::usage);
}

// A mesh that is fine at its surface and coarse inside: where the mean over all edges decided, heat went less
// far than an edge inside, and on a body of 210,000 tets distances became a fifth too small.
TEST(Distances, HeatGetsAlongTheLongEdgesInside) {
  const Result<Meshing> made = tetrahedralize(test::icosphere(4));
  ASSERT_TRUE(made.ok()) << made.error().message;
  const TetMesh& mesh = made.value().mesh;
  Index pole = 0, opposite = 0;
  for (Index v = 0; v < mesh.surface_vertices; ++v) {
    if (mesh.V(v, 2) > mesh.V(pole, 2)) pole = v;
    if (mesh.V(v, 2) < mesh.V(opposite, 2)) opposite = v;
  }
  const double exact = (mesh.V.row(pole) - mesh.V.row(opposite)).norm();
  for (const double smoothing : {0.5, 1.0, 4.0}) {
    const Result<Distances> prepared = Distances::prepare(mesh, {smoothing});
    ASSERT_TRUE(prepared.ok());
    const Result<Eigen::VectorXd> found = prepared.value().from(std::array{pole});
    ASSERT_TRUE(found.ok());
    EXPECT_NEAR(found.value()[opposite], exact, 0.1 * exact) << smoothing;
  }
  EXPECT_EQ(Distances::prepare(mesh, {0.4}).error().code, ErrorCode::usage);
}

}  // namespace
}  // namespace overtet
