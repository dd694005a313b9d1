#include "kernels/laplacian/laplacian.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "tests/support/flow_surfaces.h"

namespace overtet {
namespace {

Eigen::MatrixXd dense(const SymmetricMatrix& L) { return Eigen::MatrixXd(L).selfadjointView<Eigen::Lower>(); }

// The cotangent formula, written down a second time, with angles.
Eigen::MatrixXd brute_force(const Surface& s) {
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(s.V.rows(), s.V.rows());
  for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const Index i = s.F(f, k), a = s.F(f, (k + 1) % 3), b = s.F(f, (k + 2) % 3);
      const Eigen::Vector3d x = (s.V.row(a) - s.V.row(i)).transpose(),
                            y = (s.V.row(b) - s.V.row(i)).transpose();
      const double angle = std::acos(x.dot(y) / (x.norm() * y.norm()));
      const double w = 0.5 / std::tan(angle);
      L(a, b) -= w, L(b, a) -= w, L(a, a) += w, L(b, b) += w;
    }
  }
  return L;
}

TEST(Laplacian, CotangentMatchesAngles) {
  const Surface s = test::bumpy_capsule(0.02, 11);
  const Eigen::MatrixXd expected = brute_force(s);
  EXPECT_LT((dense(cotangent_laplacian(s.V, s.F)) - expected).norm(), 1e-9 * expected.norm());
}

TEST(Laplacian, KernelIsTheConstants) {
  const Surface s = test::bumpy_capsule(0.04, 12);
  for (const SymmetricMatrix& L :
       {cotangent_laplacian(s.V, s.F), cotangent_laplacian(s.V, s.F, 0.05),
        uniform_laplacian(static_cast<Index>(s.V.rows()), s.F), intrinsic_delaunay_laplacian(s.V, s.F)}) {
    const Eigen::MatrixXd D = dense(L);
    EXPECT_LT((D * Eigen::VectorXd::Ones(D.rows())).norm(), 1e-10 * D.norm());
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(D, Eigen::EigenvaluesOnly);
    EXPECT_GT(eigen.eigenvalues()[0], -1e-9 * D.norm());
    EXPECT_GT(eigen.eigenvalues()[1], 0);  // connected: one zero eigenvalue
  }
}

TEST(Laplacian, ClampRaisesSummedWeightsOnly) {
  const Surface s = test::bumpy_capsule(0.08, 13);
  const SymmetricMatrix free = cotangent_laplacian(s.V, s.F), clamped = cotangent_laplacian(s.V, s.F, 0.05);
  int raised = 0;
  for (int c = 0; c < free.outerSize(); ++c) {
    SymmetricMatrix::InnerIterator a(free, c), b(clamped, c);
    for (; a && b; ++a, ++b) {
      if (a.row() == a.col()) continue;
      EXPECT_EQ(b.value(), std::min(a.value(), -0.05));
      raised += a.value() > -0.05;
    }
  }
  EXPECT_GT(raised, 0) << "the test surface has no obtuse pair";
}

TEST(Laplacian, IntrinsicDelaunayHasNoNegativeWeightAndTheSameEnergyOfLinearFunctions) {
  const Surface s = test::bumpy_capsule(0.12, 14);
  const SymmetricMatrix L = intrinsic_delaunay_laplacian(s.V, s.F);
  for (int c = 0; c < L.outerSize(); ++c) {
    for (SymmetricMatrix::InnerIterator it(L, c); it; ++it) {
      if (it.row() != it.col()) {
        EXPECT_LT(it.value(), 1e-9);
      }
    }
  }
  // Flips never raise the Dirichlet energy of a function given at the vertices (Rippa).
  VertexMatrix y, z;
  multiply(L, s.V, y);
  multiply(cotangent_laplacian(s.V, s.F), s.V, z);
  EXPECT_LE((s.V.array() * y.array()).sum(), (s.V.array() * z.array()).sum() * (1 + 1e-12));
}

TEST(Laplacian, IntrinsicDelaunayLeavesDelaunayMeshesAlone) {
  const Surface s = test::icosphere(2);
  const Eigen::MatrixXd a = dense(intrinsic_delaunay_laplacian(s.V, s.F)),
                        b = dense(cotangent_laplacian(s.V, s.F));
  EXPECT_LT((a - b).norm(), 1e-9 * b.norm());
}

TEST(Laplacian, CoordinatesOfTheSphereAreNearlyEigenfunctions) {
  const Surface s = test::icosphere(4);
  VertexMatrix LV;
  multiply(cotangent_laplacian(s.V, s.F), s.V, LV);
  const Eigen::VectorXd mass = lumped_mass(s.V, s.F);
  const VertexMatrix difference = LV - 2 * mass.asDiagonal() * s.V;  // -Laplace x = 2 x on the unit sphere
  EXPECT_LT(difference.norm(), 0.02 * LV.norm());
  EXPECT_NEAR(surface_area(s.V, s.F), 4 * std::numbers::pi, 0.05);
  EXPECT_NEAR(mass.sum(), surface_area(s.V, s.F), 1e-10);
}

TEST(Laplacian, FiniteOnDegenerateTriangles) {
  Surface s = test::icosphere(2);
  for (Eigen::Index f = 0; f < 60; ++f) s.V.row(s.F(f, 1)) = s.V.row(s.F(f, 0));  // collapsed edges
  for (const SymmetricMatrix& L : {cotangent_laplacian(s.V, s.F), intrinsic_delaunay_laplacian(s.V, s.F)})
    for (Eigen::Index k = 0; k < L.nonZeros(); ++k) ASSERT_TRUE(std::isfinite(L.valuePtr()[k]));
}

}  // namespace
}  // namespace overtet
