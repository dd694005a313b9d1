// Micro-benchmarks of the flows' kernels on a bent tube of about 2 * range(0)^2 faces, one thread.
#include <benchmark/benchmark.h>

#include <random>

#include "kernels/arap/arap.h"
#include "kernels/contact/contact.h"
#include "kernels/laplacian/laplacian.h"
#include "kernels/parallel/parallel.h"
#include "kernels/sparse/cholesky.h"
#include "tests/support/flow_surfaces.h"

namespace {

using namespace overtet;

Surface surface(const benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  return test::bent_capsule(300, 1, 0.25, 2 * n, n / 2);
}

SymmetricMatrix system_of(const Surface& s) {
  SymmetricMatrix Q = cotangent_laplacian(s.V, s.F, 0.05);
  const Eigen::VectorXd mass = lumped_mass(s.V, s.F);
  for (Eigen::Index i = 0; i < Q.cols(); ++i) Q.valuePtr()[Q.outerIndexPtr()[i]] += 100 * mass[i];
  return Q;
}

ContactMesh contact_mesh(const Surface& s) {
  const double h = std::sqrt(surface_area(s.V, s.F) / static_cast<double>(s.F.rows()));
  return ContactMesh(s.V, s.F, std::vector<char>(s.V.rows(), 1), s.V,
                     Eigen::VectorXd::Constant(s.V.rows(), h));
}

void faces_per_second(benchmark::State& state, const Surface& s) {
  state.SetItemsProcessed(state.iterations() * s.F.rows());
}

void BM_BestRotation(benchmark::State& state) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Matrix3d> matrices(1000);
  for (auto& S : matrices)
    for (int i = 0; i < 9; ++i) S.data()[i] = normal(random);
  for (auto _ : state)
    for (const auto& S : matrices) benchmark::DoNotOptimize(best_rotation(S));
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(BM_BestRotation);

void BM_ArapStep(benchmark::State& state) {
  const ScopedThreads one(1);
  const Surface s = surface(state);
  Arap arap(s.V, s.F);
  VertexMatrix G;
  for (auto _ : state) {
    arap.fit_rotations(s.V);
    arap.gradient(s.V, G);
  }
  faces_per_second(state, s);
}
BENCHMARK(BM_ArapStep)->Arg(70)->Arg(200);

void BM_CotangentLaplacian(benchmark::State& state) {
  const ScopedThreads one(1);
  const Surface s = surface(state);
  for (auto _ : state) benchmark::DoNotOptimize(cotangent_laplacian(s.V, s.F));
  faces_per_second(state, s);
}
BENCHMARK(BM_CotangentLaplacian)->Arg(70)->Arg(200);

void BM_IntrinsicDelaunayLaplacian(benchmark::State& state) {
  const Surface s = surface(state);
  for (auto _ : state) benchmark::DoNotOptimize(intrinsic_delaunay_laplacian(s.V, s.F));
  faces_per_second(state, s);
}
BENCHMARK(BM_IntrinsicDelaunayLaplacian)->Arg(70)->Arg(200);

void BM_CholeskyAnalyze(benchmark::State& state) {
  const Surface s = surface(state);
  const SymmetricMatrix Q = system_of(s);
  SparseCholesky factor;
  for (auto _ : state) benchmark::DoNotOptimize(factor.analyze(Q));
  faces_per_second(state, s);
}
BENCHMARK(BM_CholeskyAnalyze)->Arg(70)->Arg(200);

void BM_CholeskyFactor(benchmark::State& state) {
  const Surface s = surface(state);
  const SymmetricMatrix Q = system_of(s);
  SparseCholesky factor;
  factor.analyze(Q);
  for (auto _ : state) benchmark::DoNotOptimize(factor.factor(Q));
  faces_per_second(state, s);
}
BENCHMARK(BM_CholeskyFactor)->Arg(70)->Arg(200);

void BM_CholeskySolve(benchmark::State& state) {
  const Surface s = surface(state);
  const SymmetricMatrix Q = system_of(s);
  SparseCholesky factor;
  factor.analyze(Q);
  factor.factor(Q);
  VertexMatrix x;
  for (auto _ : state) benchmark::DoNotOptimize(factor.solve(s.V, x));
  faces_per_second(state, s);
}
BENCHMARK(BM_CholeskySolve)->Arg(70)->Arg(200);

void BM_Intersections(benchmark::State& state) {
  const ScopedThreads one(1);
  const Surface s = surface(state);
  ContactMesh mesh = contact_mesh(s);
  for (auto _ : state) benchmark::DoNotOptimize(mesh.intersections(s.V));
  faces_per_second(state, s);
}
BENCHMARK(BM_Intersections)->Arg(70)->Arg(200);

// Pairs remembered, as in the late iterations of a reverse flow.
void BM_FindContacts(benchmark::State& state) {
  const ScopedThreads one(1);
  const Surface s = surface(state);
  ContactMesh mesh = contact_mesh(s);
  for (auto _ : state) benchmark::DoNotOptimize(mesh.find_contacts(s.V));
  faces_per_second(state, s);
}
BENCHMARK(BM_FindContacts)->Arg(70)->Arg(200);

// A long step: swept boxes, no memory.
void BM_CheckStep(benchmark::State& state) {
  const ScopedThreads one(1);
  const Surface s = surface(state);
  ContactMesh mesh = contact_mesh(s);
  const VertexMatrix P = 0.05 * s.V;
  for (auto _ : state) benchmark::DoNotOptimize(mesh.check_step(s.V, P));
  faces_per_second(state, s);
}
BENCHMARK(BM_CheckStep)->Arg(70)->Arg(200);

}  // namespace

BENCHMARK_MAIN();
