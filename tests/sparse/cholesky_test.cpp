#include "kernels/sparse/cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <limits>
#include <random>
#include <thread>
#include <vector>

namespace overtet {
namespace {

// Lower triangle of a random sparse matrix, strictly diagonally dominant.
SymmetricMatrix random_matrix(int n, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1, 1);
  std::uniform_int_distribution<int> index(0, std::max(0, n - 1));
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> diagonal(n, 0.5);
  for (int k = 0; k < 4 * n; ++k) {
    const int i = index(random), j = index(random);
    if (i == j) continue;
    const double v = value(random);
    entries.emplace_back(std::max(i, j), std::min(i, j), v);
    diagonal[i] += std::abs(v), diagonal[j] += std::abs(v);
  }
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, diagonal[i]);
  SymmetricMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

TEST(SparseCholesky, SolvesWithEveryOption) {
  const std::uint32_t seed = 7;
  RecordProperty("seed", static_cast<int>(seed));
  using O = CholeskyOptions;
  for (int n : {0, 1, 2, 50, 400}) {
    const SymmetricMatrix A = random_matrix(n, seed + n);
    VertexMatrix expected = VertexMatrix::Random(n, 3), b, x;
    multiply(A, expected, b);
    if (n > 0) {
      const Eigen::MatrixXd dense = Eigen::MatrixXd(A).selfadjointView<Eigen::Lower>();
      EXPECT_LT((dense * expected - b).norm(), 1e-12 * b.norm());
    }
    for (auto ordering : {O::Ordering::amd, O::Ordering::metis, O::Ordering::natural}) {
      for (auto method : {O::Method::simplicial, O::Method::supernodal, O::Method::automatic}) {
        SparseCholesky factor({ordering, method});
        ASSERT_TRUE(factor.analyze(A));
        ASSERT_TRUE(factor.factor(A));
        ASSERT_TRUE(factor.solve(b, x));
        EXPECT_LT((x - expected).norm(), 1e-10 * (1 + expected.norm()));
      }
    }
  }
}

// Also with a BLAS that has no locks of its own (libopenblas0-serial).
TEST(SparseCholesky, FactorsInSeveralThreads) {
  const SymmetricMatrix A = random_matrix(700, 13);
  const VertexMatrix expected = VertexMatrix::Random(700, 3);
  VertexMatrix b;
  multiply(A, expected, b);
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      SparseCholesky factor({CholeskyOptions::Ordering::amd, CholeskyOptions::Method::supernodal});
      if (!factor.analyze(A)) ++wrong;
      VertexMatrix x;
      for (int n = 0; n < 20; ++n)
        if (!factor.factor(A) || !factor.solve(b, x) || (x - expected).norm() > 1e-10 * expected.norm())
          ++wrong;
    });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
}

TEST(SparseCholesky, OrdersPartsAsTheWhole) {
  const SymmetricMatrix A = random_matrix(200, 17);
  SparseCholesky whole({CholeskyOptions::Ordering::metis, CholeskyOptions::Method::simplicial});
  ASSERT_TRUE(whole.analyze(A));
  std::vector<int> order = whole.order();
  std::sort(order.begin(), order.end());
  for (int i = 0; i < 200; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

TEST(SparseCholesky, RefactorsWithTheSamePattern) {
  SymmetricMatrix A = random_matrix(100, 3);
  SparseCholesky factor;
  ASSERT_TRUE(factor.analyze(A));
  for (double scale : {1.0, 2.0, 1e6}) {
    SymmetricMatrix scaled = A * scale;
    VertexMatrix x = VertexMatrix::Random(100, 3), b;
    multiply(scaled, x, b);
    ASSERT_TRUE(factor.factor(scaled));
    VertexMatrix solved = b;
    ASSERT_TRUE(factor.solve(solved, solved));
    EXPECT_LT((solved - x).norm(), 1e-10 * x.norm());
  }
}

TEST(SparseCholesky, RefusesWhatIsNotPositiveDefinite) {
  SymmetricMatrix A = random_matrix(40, 5);
  SparseCholesky factor;
  ASSERT_TRUE(factor.analyze(A));
  SymmetricMatrix indefinite = A;
  indefinite.coeffRef(17, 17) = -1;
  EXPECT_FALSE(factor.factor(indefinite));
  VertexMatrix b = VertexMatrix::Random(40, 3), x;
  EXPECT_FALSE(factor.solve(b, x));
  SymmetricMatrix nan = A;
  nan.coeffRef(17, 17) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(factor.factor(nan));
  EXPECT_FALSE(factor.factor(random_matrix(41, 5)));  // another pattern
  EXPECT_TRUE(factor.factor(A));                      // and it recovers
  EXPECT_TRUE(factor.solve(b, x));
}

}  // namespace
}  // namespace overtet
