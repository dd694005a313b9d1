#include "kernels/arap/arap.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <random>

#include "kernels/parallel/parallel.h"
#include "tests/support/flow_surfaces.h"

namespace overtet {
namespace {

constexpr std::uint32_t kSeed = 20130703;

Eigen::Matrix3d rotation_by_svd(const Eigen::Matrix3d& S) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d V = svd.matrixV();
  if ((V * svd.matrixU().transpose()).determinant() < 0) V.col(2) *= -1;
  return V * svd.matrixU().transpose();
}

VertexMatrix moved(const VertexMatrix& V, double amplitude, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  VertexMatrix U = V;
  for (Eigen::Index i = 0; i < U.size(); ++i) U.data()[i] += uniform(random);
  return U;
}

TEST(BestRotation, MaximisesTheTraceLikeSvd) {
  RecordProperty("seed", static_cast<int>(kSeed));
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20000; ++trial) {
    Eigen::Matrix3d S;
    for (int i = 0; i < 9; ++i) S.data()[i] = normal(random);
    if (trial % 5 == 1) S.col(0) = S.col(1);                     // rank 2
    if (trial % 5 == 2) S = S.col(0) * S.row(1);                 // rank 1
    if (trial % 5 == 3) S *= std::pow(10.0, trial % 200 - 100);  // any size
    if (trial % 5 == 4) S.col(2) = S.col(1) + 1e-7 * S.col(0);   // nearly rank 2
    const Eigen::Matrix3d R = best_rotation(S), expected = rotation_by_svd(S);
    ASSERT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-9);
    ASSERT_GT(R.determinant(), 0);
    ASSERT_GE((R * S).trace(), (expected * S).trace() - 1e-9 * S.norm()) << "trial " << trial;
  }
}

TEST(BestRotation, RecoversARotationAndSurvivesNothing) {
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 1000; ++trial) {
    Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
    q.normalize();
    Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
    for (int k = 0; k < 6; ++k) {
      const Eigen::Vector3d w(normal(random), normal(random), normal(random));
      S += w * (q * w).transpose();
    }
    ASSERT_LT((best_rotation(S) - q.toRotationMatrix()).norm(), 1e-9);
  }
  EXPECT_EQ(best_rotation(Eigen::Matrix3d::Zero()), Eigen::Matrix3d::Identity());
}

TEST(Arap, RigidMotionsCostNothing) {
  const Surface s = test::bumpy_capsule(0.03, kSeed);
  Arap arap(s.V, s.F);
  const Eigen::Quaterniond q = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.1).normalized();
  VertexMatrix U = s.V * q.toRotationMatrix().transpose(), G;
  U.rowwise() += Eigen::RowVector3d(1, -2, 3);
  arap.fit_rotations(U);
  arap.gradient(U, G);
  EXPECT_NEAR(arap.energy(U), 0, 1e-12);
  EXPECT_LT(G.norm(), 1e-9);
}

TEST(Arap, GradientAgainstFiniteDifferencesOfTheMinimisedEnergy) {
  std::mt19937 random(kSeed);
  const Surface s = test::bumpy_capsule(0.03, kSeed);
  const VertexMatrix U = moved(s.V, 0.1, random);
  Arap arap(s.V, s.F);
  const auto minimised = [&](const VertexMatrix& X) {
    arap.fit_rotations(X);
    return arap.energy(X);
  };
  arap.fit_rotations(U);
  VertexMatrix G;
  arap.gradient(U, G);
  for (int trial = 0; trial < 10; ++trial) {
    const VertexMatrix D = moved(VertexMatrix::Zero(U.rows(), 3), 1, random);
    const double h = 1e-6, slope = (minimised(U + h * D) - minimised(U - h * D)) / (2 * h);
    EXPECT_NEAR(slope, (G.array() * D.array()).sum(), 1e-5 * G.norm() * D.norm());
  }
}

TEST(Arap, QuadraticPartIsTheLaplacian) {
  std::mt19937 random(kSeed);
  const Surface s = test::bumpy_capsule(0.03, kSeed);
  const VertexMatrix U = moved(s.V, 0.1, random), D = moved(VertexMatrix::Zero(U.rows(), 3), 1, random);
  Arap arap(s.V, s.F);
  arap.fit_rotations(U);
  VertexMatrix G0, G1, LD;
  arap.gradient(U, G0);
  arap.gradient(U + D, G1);
  multiply(arap.matrix(), D, LD);
  EXPECT_LT((G1 - G0 - LD).norm(), 1e-9 * LD.norm());
}

TEST(Arap, SameBytesOnAnyNumberOfThreads) {
  std::mt19937 random(kSeed);
  const Surface s = test::icosphere(4);
  const VertexMatrix U = moved(s.V, 0.05, random);
  VertexMatrix first;
  double first_energy = 0;
  for (int threads : {1, 2, 3, 8}) {
    const ScopedThreads scope(threads);
    Arap arap(s.V, s.F);
    arap.fit_rotations(U);
    VertexMatrix G;
    arap.gradient(U, G);
    if (threads == 1) first = G, first_energy = arap.energy(U);
    EXPECT_TRUE((G.array() == first.array()).all());
    EXPECT_EQ(arap.energy(U), first_energy);
  }
}

}  // namespace
}  // namespace overtet
