#include "kernels/arap/volume_arap.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <random>

#include "kernels/parallel/parallel.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

constexpr std::uint32_t kBlockSeed = 2010;

TetMesh shaken_block(int n) { return test::grid_tets(n, 0.1, kBlockSeed); }

VertexMatrix displaced(const VertexMatrix& V, double amplitude, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  VertexMatrix U = V;
  for (Eigen::Index i = 0; i < U.size(); ++i) U.data()[i] += uniform(random);
  return U;
}

Eigen::Matrix3d edges(const VertexMatrix& X, const TetMatrix& T, Eigen::Index t) {
  Eigen::Matrix3d E;
  for (int k = 0; k < 3; ++k) E.col(k) = X.row(T(t, k + 1)) - X.row(T(t, 0));
  return E;
}

// The definition, tet by tet, with rotations by SVD.
double brute_energy(const TetMesh& rest, const VertexMatrix& U) {
  double sum = 0;
  for (Eigen::Index t = 0; t < rest.T.rows(); ++t) {
    const Eigen::Matrix3d W = edges(rest.V, rest.T, t), J = edges(U, rest.T, t) * W.inverse();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(J, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d A = svd.matrixU();
    if ((A * svd.matrixV().transpose()).determinant() < 0) A.col(2) *= -1;
    sum += W.determinant() / 12 * (J - A * svd.matrixV().transpose()).squaredNorm();
  }
  return sum;
}

TEST(VolumeArap, EnergyIsThatOfTheDefinitionFlippedTetsIncluded) {
  const TetMesh mesh = shaken_block(3);
  for (const double amplitude : {0.0, 0.2, 2.0}) {
    const VertexMatrix U = displaced(mesh.V, amplitude, kBlockSeed + 1);
    VolumeArap arap(mesh.V, mesh.T);
    arap.fit_rotations(U);
    EXPECT_NEAR(arap.energy(U), brute_energy(mesh, U), 1e-9 * (1 + brute_energy(mesh, U)));
  }
}

TEST(VolumeArap, RigidMotionsCostNothing) {
  const TetMesh mesh = shaken_block(2);
  const Eigen::Quaterniond q = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.1).normalized();
  VertexMatrix U = mesh.V * q.toRotationMatrix().transpose(), G;
  U.rowwise() += Eigen::RowVector3d(1, -2, 3);
  VolumeArap arap(mesh.V, mesh.T);
  arap.fit_rotations(U);
  arap.gradient(U, G);
  EXPECT_NEAR(arap.energy(U), 0, 1e-12);
  EXPECT_LT(G.norm(), 1e-9);
}

TEST(VolumeArap, GradientAgainstFiniteDifferencesOfTheMinimisedEnergy) {
  const TetMesh mesh = shaken_block(2);
  const VertexMatrix U = displaced(mesh.V, 0.2, kBlockSeed + 2);
  VolumeArap arap(mesh.V, mesh.T);
  arap.fit_rotations(U);
  VertexMatrix G;
  arap.gradient(U, G);
  for (Eigen::Index i = 0; i < U.size(); i += 5) {
    VertexMatrix X = U;
    const double h = 1e-6;
    X.data()[i] += h;
    const double plus = brute_energy(mesh, X);
    X.data()[i] -= 2 * h;
    EXPECT_NEAR((plus - brute_energy(mesh, X)) / (2 * h), G.data()[i], 1e-6 * (1 + G.norm()));
  }
}

// For fixed rotations E is quadratic, and L is its second derivative.
TEST(VolumeArap, MatrixIsTheQuadraticPart) {
  const TetMesh mesh = shaken_block(2);
  const VertexMatrix U = displaced(mesh.V, 0.2, kBlockSeed + 3),
                     D = displaced(mesh.V, 0.3, kBlockSeed + 4) - mesh.V;
  VolumeArap arap(mesh.V, mesh.T);
  arap.fit_rotations(U);
  VertexMatrix G, H, LD;
  arap.gradient(U, G);
  arap.gradient(U + D, H);
  multiply(arap.matrix(), D, LD);
  EXPECT_LT((H - G - LD).norm(), 1e-10 * H.norm());
}

TEST(VolumeArap, SameBytesOnAnyNumberOfThreads) {
  const TetMesh mesh = shaken_block(6);
  const VertexMatrix U = displaced(mesh.V, 0.2, kBlockSeed + 5);
  VertexMatrix G[2];
  double energy[2];
  for (const int threads : {1, 4}) {
    const ScopedThreads scope(threads);
    VolumeArap arap(mesh.V, mesh.T);
    arap.fit_rotations(U);
    arap.gradient(U, G[threads / 4]);
    energy[threads / 4] = arap.energy(U);
  }
  EXPECT_EQ(G[0], G[1]);
  EXPECT_EQ(energy[0], energy[1]);
}

}  // namespace
}  // namespace overtet
