// Matrices of finite elements: exact for the polynomials that they hold, and the sums of what each tet adds.
#include "kernels/fem/elements.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "kernels/core/tet_tables.h"
#include "kernels/parallel/parallel.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

Eigen::MatrixXd full(const SymmetricMatrix& A) {
  return Eigen::MatrixXd(Eigen::SparseMatrix<double>(A.selfadjointView<Eigen::Lower>()));
}

// A polynomial of the order of the elements, and its gradient.
double cubic_free(const Eigen::Vector3d& p, int order) {
  const double linear = 1 + 2 * p[0] - p[1] + 0.5 * p[2];
  return order == 1 ? linear : linear + p[0] * p[0] - 3 * p[1] * p[2] + p[2] * p[2] + p[0] * p[1];
}
Eigen::Vector3d slope(const Eigen::Vector3d& p, int order) {
  const Eigen::Vector3d linear(2, -1, 0.5);
  if (order == 1) return linear;
  return linear + Eigen::Vector3d(2 * p[0] + p[1], -3 * p[2] + p[0], -3 * p[1] + 2 * p[2]);
}

Eigen::VectorXd at_nodes(const TetElements& e) {
  Eigen::VectorXd u(e.nodes());
  for (Index v = 0; v < e.nodes(); ++v) u[v] = cubic_free(e.places().row(v).transpose(), e.order());
  return u;
}

TEST(Elements, MassIsTheVolumeAndEnergyIsExact) {
  const TetMesh m = test::grid_tets(3, 0.2, 7);
  double volume = 0;
  for (Eigen::Index t = 0; t < m.T.rows(); ++t) volume += tet_shape(m.V, m.T, t).volume;
  for (const int order : {1, 2}) {
    const TetElements e(m.V, m.T, order);
    const Eigen::MatrixXd M = full(e.mass()), K = full(e.stiffness());
    EXPECT_NEAR(M.sum(), volume, 1e-12 * volume);
    EXPECT_LT((K * Eigen::VectorXd::Ones(K.rows())).cwiseAbs().maxCoeff(), 1e-12);
    const Eigen::VectorXd u = at_nodes(e);
    // |grad u|^2 is of degree 2 at most: four points in each tet give its integral.
    double exact = 0;
    const double a = (5 + 3 * std::sqrt(5.0)) / 20, b = (5 - std::sqrt(5.0)) / 20;
    for (Eigen::Index t = 0; t < m.T.rows(); ++t)
      for (int k = 0; k < 4; ++k) {
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        for (int i = 0; i < 4; ++i) p += (i == k ? a : b) * m.V.row(m.T(t, i)).transpose();
        exact += tet_shape(m.V, m.T, t).volume / 4 * slope(p, order).squaredNorm() / 2;
      }
    EXPECT_NEAR(u.dot(K * u) / 2, exact, 1e-11 * exact);
    EXPECT_NEAR(e.energy(u).sum(), exact, 1e-11 * exact);
  }
}

// The sums of the tets' own matrices, one after the other.
TEST(Elements, MatricesAreTheSumsOfWhatTetsAdd) {
  const TetMesh m = test::grid_tets(2, 0.25, 11);
  for (const int order : {1, 2}) {
    const TetElements e(m.V, m.T, order);
    const Eigen::MatrixXd reference = reference_mass(3, order);
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(e.nodes(), e.nodes());
    for (Index t = 0; t < e.tets(); ++t)
      for (int i = 0; i < e.nodes_each(); ++i)
        for (int j = 0; j < e.nodes_each(); ++j)
          M(e.node(t, i), e.node(t, j)) += e.shape(t).volume * reference(i, j);
    EXPECT_LT((M - full(e.mass())).cwiseAbs().maxCoeff(), 1e-15);
  }
  const TetElements e(m.V, m.T, 1);
  EXPECT_LT((full(e.mass()).rowwise().sum() - e.lumped_mass()).cwiseAbs().maxCoeff(), 1e-15);
  const Eigen::VectorXd u = at_nodes(e);
  const VertexMatrix G = e.gradient(u);
  for (Index t = 0; t < e.tets(); ++t) EXPECT_LT((G.row(t).transpose() - slope({}, 1)).norm(), 1e-12);
  // div grad = -K
  EXPECT_LT((e.divergence(G) - full(e.stiffness()) * u).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Elements, MiddlesAreNumberedLikeTheFilesOfSecondOrder) {
  const TetMesh m = test::grid_tets(2, 0, 1);
  const TetElements e(m.V, m.T, 2);
  std::array<Index, 2> before{-1, -1};
  Index next = static_cast<Index>(m.V.rows());
  for (Index a = 0; a < m.V.rows(); ++a)
    for (Index b = a + 1; b < m.V.rows(); ++b) {
      bool joined = false;
      for (Index t = 0; t < e.tets() && !joined; ++t) {
        int corners = 0;
        for (int k = 0; k < 4; ++k) corners += m.T(t, k) == a || m.T(t, k) == b;
        joined = corners == 2;
      }
      if (!joined) continue;
      EXPECT_EQ(e.middle(b, a), next++);
      EXPECT_EQ(e.places().row(e.middle(a, b)), (m.V.row(a) + m.V.row(b)) / 2);
    }
  EXPECT_EQ(next, e.nodes());
}

TEST(Elements, SameBytesOnAnyNumberOfThreads) {
  const TetMesh m = test::grid_tets(12, 0.2, 3);
  for (const int order : {1, 2}) {
    std::vector<SymmetricMatrix> K;
    for (const int threads : {1, 4}) {
      const ScopedThreads scope(threads);
      const TetElements e(m.V, m.T, order);
      K.push_back(e.stiffness());
    }
    ASSERT_EQ(K[0].nonZeros(), K[1].nonZeros());
    EXPECT_TRUE(std::equal(K[0].valuePtr(), K[0].valuePtr() + K[0].nonZeros(), K[1].valuePtr()));
  }
}

}  // namespace
}  // namespace overtet
