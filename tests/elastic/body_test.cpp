// Elastic bodies: assembled forces and matrices against finite differences, and the same on any number of
// threads.
#include "kernels/elastic/body.h"

#include <gtest/gtest.h>

#include <random>

#include "kernels/parallel/parallel.h"
#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

constexpr unsigned kBodySeed = 5;

struct Sample {
  TetMesh mesh = test::grid_tets(3, 0.2, kBodySeed);
  VertexMatrix x;
  std::vector<Index> number;
  Sample() {
    std::mt19937 random(kBodySeed);
    std::uniform_real_distribution<double> of(-0.05, 0.05);
    x = mesh.V;
    for (double& c : x.reshaped()) c = 1.1 * c + of(random);
    Index free = 0;
    for (Index v = 0; v < mesh.V.rows(); ++v) number.push_back(v % 7 == 3 ? -1 : free++);
  }
  ElasticBody body(ElasticMaterial m) const { return {mesh.V, mesh.T, {m, lame_of(1, 0.3)}, number}; }
};

TEST(Body, ForcesAndMatricesAreDerivatives) {
  const Sample s;
  for (const ElasticMaterial m :
       {ElasticMaterial::st_venant_kirchhoff, ElasticMaterial::corotated, ElasticMaterial::neo_hookean}) {
    const ElasticBody body = s.body(m);
    ASSERT_LT(body.first_flipped(s.x), 0);
    std::mt19937 random(kBodySeed);
    std::uniform_real_distribution<double> of(-1, 1);
    const VertexMatrix d = VertexMatrix::NullaryExpr(s.x.rows(), 3, [&] { return of(random); });
    const double h = 1e-6;
    ElasticBody::Stresses P;
    double size = 0;
    const auto gradient = [&](const VertexMatrix& x) {
      EXPECT_EQ(body.stresses(x, P), body.energy(x));
      return body.gathered(P, size);
    };
    const VertexMatrix g = gradient(s.x);
    EXPECT_GT(size, 0.99 * g.norm() / 5);
    const double slope = (body.energy(s.x + h * d) - body.energy(s.x - h * d)) / (2 * h);
    EXPECT_NEAR(g.cwiseProduct(d).sum(), slope, 1e-6 * g.norm() * d.norm());
    const VertexMatrix change = (gradient(s.x + h * d) - gradient(s.x - h * d)) / (2 * h);

    ElasticBody::Tangents tangents;
    body.tangents(s.x, Tangent::exact, tangents);
    ElasticBody::Stresses changes(static_cast<std::size_t>(body.tets()), Eigen::Matrix3d::Zero());
    body.add_change(tangents, d, 1, changes);
    const VertexMatrix Kd = body.gathered(changes, size);
    EXPECT_LT((Kd - change).norm(), 1e-6 * change.norm());
    EXPECT_NEAR(body.curvature(tangents, d), d.cwiseProduct(Kd).sum(), 1e-9 * d.norm() * Kd.norm());

    // The matrix is the same for the vertices that have a number.
    VertexMatrix kept = d;
    for (std::size_t v = 0; v < s.number.size(); ++v)
      if (s.number[v] < 0) kept.row(static_cast<Eigen::Index>(v)).setZero();
    std::fill(changes.begin(), changes.end(), Eigen::Matrix3d::Zero());
    body.add_change(tangents, kept, 3, changes);
    const VertexMatrix wanted = body.gathered(changes, size);
    SymmetricMatrix A;
    const Eigen::VectorXd diagonal = Eigen::VectorXd::LinSpaced(s.x.rows(), 1, 2);
    body.assemble({{&tangents, 1}, {&tangents, 2}}, diagonal, A);
    ASSERT_EQ(A.rows(), body.rows());
    Eigen::VectorXd in(body.rows());
    for (Index v = 0; v < s.x.rows(); ++v)
      if (s.number[v] >= 0) in.segment<3>(3 * s.number[v]) = kept.row(v).transpose();
    const Eigen::VectorXd out = A.selfadjointView<Eigen::Lower>() * in;
    for (Index v = 0; v < s.x.rows(); ++v)
      if (s.number[v] >= 0) {
        EXPECT_LT((out.segment<3>(3 * s.number[v]) - (wanted.row(v) + diagonal[v] * kept.row(v)).transpose())
                      .norm(),
                  1e-10 * wanted.norm())
            << v;
      }
    // Again into the same matrix, only the values change.
    const int* rows = A.innerIndexPtr();
    body.assemble({{&tangents, 3}}, diagonal, A);
    EXPECT_EQ(A.innerIndexPtr(), rows);
    EXPECT_LT((Eigen::VectorXd(A.selfadjointView<Eigen::Lower>() * in) - out).norm(), 1e-12 * out.norm());
  }
}

TEST(Body, IsTheSameOnAnyNumberOfThreads) {
  const TetMesh mesh = test::grid_tets(9, 0.2, kBodySeed);
  std::vector<Index> number(static_cast<std::size_t>(mesh.V.rows()));
  for (std::size_t v = 0; v < number.size(); ++v) number[v] = static_cast<Index>(v);
  std::mt19937 random(kBodySeed);
  std::uniform_real_distribution<double> of(-0.03, 0.03);
  VertexMatrix x = mesh.V;
  for (double& c : x.reshaped()) c += of(random);
  double energy[2];
  VertexMatrix g[2];
  SymmetricMatrix A[2];
  for (int k = 0; k < 2; ++k) {
    const ScopedThreads threads(k == 0 ? 1 : 4);
    const ElasticBody body(mesh.V, mesh.T, {ElasticMaterial::neo_hookean, lame_of(1, 0.3)}, number);
    energy[k] = body.energy(x);
    ElasticBody::Stresses P;
    double size = 0;
    body.stresses(x, P);
    g[k] = body.gathered(P, size);
    ElasticBody::Tangents tangents;
    body.tangents(x, Tangent::definite, tangents);
    body.assemble({{&tangents, 1}}, Eigen::VectorXd::Ones(x.rows()), A[k]);
  }
  EXPECT_EQ(energy[0], energy[1]);
  EXPECT_EQ(g[0], g[1]);
  ASSERT_EQ(A[0].nonZeros(), A[1].nonZeros());
  EXPECT_TRUE(std::equal(A[0].valuePtr(), A[0].valuePtr() + A[0].nonZeros(), A[1].valuePtr()));
}

TEST(Body, AWayEndsBeforeATetIsFlat) {
  const Sample s;
  const ElasticBody body = s.body(ElasticMaterial::corotated);
  VertexMatrix d = VertexMatrix::Zero(s.x.rows(), 3);
  d.row(20) << 10, 0, 0;
  const ElasticBody::Way way = body.way(s.x, d, 1);
  ASSERT_LT(way.part, 1);
  ASSERT_GE(way.tet, 0);
  EXPECT_LT(body.first_flipped(s.x + 0.999 * way.part * d), 0);
  EXPECT_GE(body.first_flipped(s.x + 1.01 * way.part * d), 0);
  EXPECT_LT(body.least_ratio(s.x + way.part * d), 0.01);
  EXPECT_EQ(body.way(s.x, d, 1e-3).part, 1e-3);
}

}  // namespace
}  // namespace overtet
