// Multigrid beside the Cholesky factor: the same solutions, whatever the mesh, and the same bytes on any
// number of threads.
#include "kernels/multigrid/multigrid.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "kernels/fem/elements.h"
#include "kernels/multigrid/aggregates.h"
#include "kernels/parallel/parallel.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

struct System {
  SymmetricMatrix A;
  Eigen::VectorXd b;
};

// -Laplace(u) = (random) on a mesh, u given at about one vertex in `one_in`, and in every component.
System system_on(const TetMesh& m, int one_in, unsigned seed) {
  std::mt19937 random(seed);
  const TetElements e(m.V, m.T, 1);
  std::vector<Index> number(static_cast<std::size_t>(e.nodes()), -1);
  Index count = 0;
  for (Index k = 1; k < e.used(); ++k)
    if (random() % static_cast<unsigned>(one_in) != 0)
      number[static_cast<std::size_t>(e.sequence()[static_cast<std::size_t>(k)])] = count++;
  System s{e.stiffness(number, count), Eigen::VectorXd(count)};
  for (double& x : s.b) x = std::uniform_real_distribution(-1.0, 1.0)(random);
  return s;
}

Eigen::VectorXd factored_solution(const System& s) {
  SparseCholesky factor;
  EXPECT_TRUE(factor.analyze(s.A) && factor.factor(s.A));
  VertexMatrix right = VertexMatrix::Zero(s.b.size(), 3), left;
  right.col(0) = s.b;
  EXPECT_TRUE(factor.solve(right, left));
  return left.col(0);
}

// The iterations that it takes.
int expect_same(const System& s, const char* what) {
  Multigrid multigrid;
  EXPECT_TRUE(multigrid.prepare(s.A)) << what;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(s.b.size());
  const Iterations done = multigrid.solve(s.b, x, {});
  EXPECT_TRUE(done.converged) << what << ", residual " << done.residual;
  const Eigen::VectorXd exact = factored_solution(s);
  EXPECT_LT((x - exact).norm(), 1e-9 * exact.norm()) << what;
  const Eigen::VectorXd r = s.b - s.A.selfadjointView<Eigen::Lower>() * x;
  EXPECT_LT(r.norm(), 1.01e-12 * s.b.norm()) << what;
  return done.count;
}

TEST(Multigrid, SolvesWhatAFactorSolves) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const int one_in : {3, 30, 1000})
      expect_same(system_on(test::grid_tets(4 + 3 * static_cast<int>(seed), 0.2, seed), one_in, seed),
                  "grid");
  }
  expect_same(system_on(test::bent_grid(6, 400, 0.1, 1), 50, 1), "overlapping");
}

TEST(Multigrid, NeedsHardlyMoreIterationsOnFinerMeshes) {
  const int coarse = expect_same(system_on(test::grid_tets(8, 0.2, 1), 40, 1), "8^3 cells");
  const int fine = expect_same(system_on(test::grid_tets(24, 0.2, 1), 40, 1), "24^3 cells");
  EXPECT_LE(fine, coarse + 12);
}

// Tets a hundred times wider than high, and vertices that are moved nearly into their neighbours.
TEST(Multigrid, BadlyShapedTetsAreSolvedOrSaidNotToBe) {
  for (const double flat : {0.3, 0.1, 0.01, 1e-4, 1e-7}) {
    TetMesh m = test::grid_tets(12, 0.2, 2);
    m.V.col(2) *= flat;
    const System s = system_on(m, 50, 2);
    Multigrid multigrid;
    ASSERT_TRUE(multigrid.prepare(s.A)) << flat;
    Eigen::VectorXd x = Eigen::VectorXd::Zero(s.b.size());
    const Iterations done = multigrid.solve(s.b, x, {});
    const Eigen::VectorXd r = s.b - s.A.selfadjointView<Eigen::Lower>() * x;
    EXPECT_TRUE(done.converged ? done.residual <= 1e-10 : done.residual > 1e-12)
        << flat << ' ' << done.residual;
    // Where rounding is most of it, it depends on the order of sums.
    EXPECT_NEAR(done.residual, r.norm() / s.b.norm(), 1e-13 + 0.3 * done.residual) << flat;
    EXPECT_LE(done.count, IterationOptions().most_iterations);
    if (flat >= 0.1) EXPECT_TRUE(done.converged) << flat << ", residual " << done.residual;
  }
}

TEST(Multigrid, ComponentsAndUnknownsWithoutNeighbours) {
  const TetMesh one = test::grid_tets(9, 0.1, 4);
  TetMesh two = one;
  two.V.conservativeResize(2 * one.V.rows(), 3);
  two.V.bottomRows(one.V.rows()) = one.V * 1e3;
  two.T.conservativeResize(2 * one.T.rows(), 4);
  two.T.bottomRows(one.T.rows()) = one.T.array() + static_cast<Index>(one.V.rows());
  expect_same(system_on(two, 20, 7), "two components");
  System s;
  s.A.resize(2000, 2000);
  s.A.setIdentity();
  s.b = Eigen::VectorXd::LinSpaced(2000, -1, 3);
  s.A.coeffRef(7, 7) = 1e6;
  s.A.makeCompressed();
  expect_same(s, "a diagonal matrix");
}

TEST(Multigrid, TinySystems) {
  Multigrid multigrid;
  Eigen::VectorXd x;
  ASSERT_TRUE(multigrid.prepare(SymmetricMatrix(0, 0)));
  EXPECT_TRUE(multigrid.solve(x, x, {}).converged);
  SymmetricMatrix A(1, 1);
  A.insert(0, 0) = 4;
  A.makeCompressed();
  ASSERT_TRUE(multigrid.prepare(A));
  x = Eigen::VectorXd::Zero(1);
  EXPECT_TRUE(multigrid.solve(Eigen::VectorXd::Constant(1, 2), x, {}).converged);
  EXPECT_DOUBLE_EQ(x[0], 0.5);
  EXPECT_TRUE(multigrid.solve(Eigen::VectorXd::Zero(1), x, {}).converged);
  EXPECT_EQ(x[0], 0);
  A.resize(2, 2);
  A.insert(0, 0) = 2, A.insert(1, 0) = -1, A.insert(1, 1) = 2;
  A.makeCompressed();
  ASSERT_TRUE(multigrid.prepare(A));
  x = Eigen::VectorXd::Zero(2);
  EXPECT_TRUE(multigrid.solve(Eigen::Vector2d(1, 1), x, {}).converged);
  EXPECT_NEAR((x - Eigen::Vector2d(1, 1)).norm(), 0, 1e-15);
}

TEST(Multigrid, WhatIsNotPositiveDefiniteIsRefused) {
  System s = system_on(test::grid_tets(10, 0.1, 1), 30, 1);
  Multigrid multigrid;
  for (const double wrong : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN()}) {
    SymmetricMatrix A = s.A;
    A.coeffRef(17, 17) = wrong;
    EXPECT_FALSE(multigrid.prepare(A)) << wrong;
  }
  // One that its diagonal does not give away: said, or not converged; in any case it ends.
  SymmetricMatrix A = s.A;
  A.coeffRef(17, 17) *= 0.01;
  if (multigrid.prepare(A)) {
    Eigen::VectorXd x = Eigen::VectorXd::Zero(s.b.size());
    const Iterations done = multigrid.solve(s.b, x, {});
    EXPECT_TRUE(done.converged ? done.residual <= 1e-10 : done.residual > 1e-12) << done.residual;
  }
}

TEST(Multigrid, StopsWhenAsked) {
  const System s = system_on(test::grid_tets(10, 0.1, 1), 30, 1);
  Multigrid multigrid;
  ASSERT_TRUE(multigrid.prepare(s.A));
  Eigen::VectorXd x = Eigen::VectorXd::Zero(s.b.size());
  int asked = 0;
  const Iterations done = multigrid.solve(s.b, x, {.stop = [&] { return ++asked > 3; }});
  EXPECT_FALSE(done.converged);
  EXPECT_LE(done.count, 3);
}

TEST(Multigrid, SameBytesOnAnyNumberOfThreads) {
  const System s = system_on(test::grid_tets(20, 0.2, 3), 40, 3);
  std::vector<Eigen::VectorXd> found;
  for (const int threads : {1, 2, 3}) {
    const ScopedThreads scope(threads);
    Multigrid multigrid;
    ASSERT_TRUE(multigrid.prepare(s.A));
    found.push_back(Eigen::VectorXd::Zero(s.b.size()));
    EXPECT_TRUE(multigrid.solve(s.b, found.back(), {}).converged);
  }
  for (const Eigen::VectorXd& x : found) EXPECT_TRUE((x.array() == found[0].array()).all());
}

Eigen::MatrixXd dense(const RowMatrix& A) { return Eigen::MatrixXd(A); }

TEST(Rows, AreAsEigenMakesThem) {
  const System s = system_on(test::grid_tets(5, 0.2, 5), 10, 5);
  const RowMatrix A = both_triangles(s.A);
  EXPECT_EQ(dense(A), Eigen::MatrixXd(Eigen::SparseMatrix<double>(s.A.selfadjointView<Eigen::Lower>())));
  const RowMatrix P = smoothed_prolongation(A, aggregates_of(A, 0.02), 0.02);
  EXPECT_LT(P.cols(), P.rows() / 4);
  EXPECT_EQ(dense(transposed(P)), dense(P).transpose());
  EXPECT_LT((dense(product(A, P)) - dense(A) * dense(P)).cwiseAbs().maxCoeff(), 1e-13);
  // Long rows, which make the table of sums grow.
  const RowMatrix squared = product(A, A);
  EXPECT_LT((dense(product(squared, squared)) - dense(squared) * dense(squared)).cwiseAbs().maxCoeff(),
            1e-11);
}

// A constant far from what is given stays one.
TEST(Rows, ProlongationsKeepConstants) {
  const TetMesh m = test::grid_tets(8, 0.2, 6);
  const RowMatrix A = both_triangles(TetElements(m.V, m.T, 1).stiffness());
  const RowMatrix P = smoothed_prolongation(A, aggregates_of(A, 0.02), 0.02);
  EXPECT_LT((P * Eigen::VectorXd::Ones(P.cols()) - Eigen::VectorXd::Ones(P.rows())).cwiseAbs().maxCoeff(),
            1e-12);
}

}  // namespace
}  // namespace overtet
