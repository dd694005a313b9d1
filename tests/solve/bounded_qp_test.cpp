// Quadratic programs with bounds, against all active sets there are.
#include "src/solve/bounded_qp.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <random>

namespace overtet {
namespace {

using solve_detail::BoundedQp;
using solve_detail::BoundedSolution;
using Vector = Eigen::VectorXd;

// The least energy: every unknown at 0, at 1 or free, one combination after the other.
double brute_force(const Eigen::MatrixXd& Q, const Vector& c, Vector& best) {
  const auto n = c.size();
  double least = std::numeric_limits<double>::infinity();
  int combinations = 1;
  for (Eigen::Index i = 0; i < n; ++i) combinations *= 3;
  for (int code = 0; code < combinations; ++code) {
    std::vector<int> free;
    Vector x = Vector::Zero(n);
    for (int i = 0, rest = code; i < n; ++i, rest /= 3) {
      if (rest % 3 == 2) free.push_back(i);
      x[i] = rest % 3 == 1;
    }
    const auto m = std::ssize(free);
    if (m > 0) {
      Eigen::MatrixXd A(m, m);
      Vector b(m);
      const Vector g = Q * x + c;
      for (Eigen::Index i = 0; i < m; ++i) {
        b[i] = -g[free[i]];
        for (Eigen::Index j = 0; j < m; ++j) A(i, j) = Q(free[i], free[j]);
      }
      const Vector y = A.ldlt().solve(b);
      for (Eigen::Index i = 0; i < m; ++i) x[free[i]] = y[i];
    }
    if (x.minCoeff() < -1e-12 || x.maxCoeff() > 1 + 1e-12) continue;
    if (const double energy = x.dot(Q * x) / 2 + c.dot(x); energy < least) {
      least = energy;
      best = x;
    }
  }
  return least;
}

TEST(BoundedQp, FindsTheBestOfAllActiveSets) {
  const unsigned seed = std::random_device()();
  RecordProperty("seed", static_cast<int>(seed));
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::normal_distribution<double> value;
  for (int round = 0; round < 60; ++round) {
    const int n = 1 + round % 7;
    const Eigen::MatrixXd B = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return value(random); });
    // From well to badly conditioned.
    const Eigen::MatrixXd Q =
        B * B.transpose() + std::pow(10.0, -(round % 5)) * Eigen::MatrixXd::Identity(n, n);
    const Vector c = Vector::NullaryExpr(n, [&] { return 3 * value(random); });
    Vector best;
    const double least = brute_force(Q, c, best);
    const SymmetricMatrix lower = Eigen::MatrixXd(Q.triangularView<Eigen::Lower>()).sparseView(0, 0);
    const Result<BoundedQp> qp = BoundedQp::prepare(lower, {});
    ASSERT_TRUE(qp.ok());
    // So that the sum is positive.
    const Result<BoundedSolution> found = qp.value().solve(c, 1 - least, {});
    ASSERT_TRUE(found.ok()) << found.error().message;
    EXPECT_NEAR(found.value().energy, least, 1e-10 * (1 + std::abs(least))) << round;
    EXPECT_LT((found.value().x - best).cwiseAbs().maxCoeff(), 1e-6) << round;
    EXPECT_GE(found.value().x.minCoeff(), 0);
    EXPECT_LE(found.value().x.maxCoeff(), 1);
    EXPECT_NE(found.value().end, BoundedSolution::End::stalled) << round;
  }
}

TEST(BoundedQp, NothingToFind) {
  SymmetricMatrix none(0, 0);
  none.makeCompressed();
  const Result<BoundedQp> qp = BoundedQp::prepare(none, {});
  ASSERT_TRUE(qp.ok());
  const Result<BoundedSolution> found = qp.value().solve(Vector(0), 0, {});
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found.value().x.size(), 0);
}

}  // namespace
}  // namespace overtet
