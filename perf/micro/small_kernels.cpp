// Kernels on small dense data: the rotation fit beside Eigen's JacobiSVD, the tet energy beside differences
// of its value. 1000 matrices or tets a round.
#include <benchmark/benchmark.h>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <random>
#include <vector>

#include "kernels/arap/arap.h"
#include "kernels/tet_energy/tet_energy.h"

namespace {

using namespace overtet;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kRound = 1000;

// kind 0: anything; 1: near a rotation, as in a flow that is nearly done.
std::vector<Matrix3d> matrices(int kind) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<Matrix3d> out(kRound);
  for (Matrix3d& S : out) {
    for (int i = 0; i < 9; ++i) S.data()[i] = normal(random);
    if (kind == 1)
      S = 0.05 * S + Matrix3d(Eigen::AngleAxisd(normal(random), Vector3d::Random().normalized()));
  }
  return out;
}

Matrix3d by_svd(const Matrix3d& S) {
  const Eigen::JacobiSVD<Matrix3d> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d U = svd.matrixU();
  if ((svd.matrixV() * U.transpose()).determinant() < 0) U.col(2) *= -1;
  return svd.matrixV() * U.transpose();
}

void rotation_overtet(benchmark::State& state) {
  const auto S = matrices(static_cast<int>(state.range(0)));
  for (auto _ : state)
    for (const Matrix3d& M : S) benchmark::DoNotOptimize(best_rotation(M));
  state.SetItemsProcessed(state.iterations() * kRound);
}

void rotation_svd(benchmark::State& state) {
  const auto S = matrices(static_cast<int>(state.range(0)));
  for (auto _ : state)
    for (const Matrix3d& M : S) benchmark::DoNotOptimize(by_svd(M));
  state.SetItemsProcessed(state.iterations() * kRound);
  double worst = 0;  // of what both maximise: trace(R S)
  for (const Matrix3d& M : S)
    worst = std::max(worst, std::fabs((by_svd(M) * M).trace() - (best_rotation(M) * M).trace()));
  state.counters["difference"] = worst;
  if (worst > 1e-9) state.SkipWithError("the rotations differ");
}

struct Tet {
  Vector3d p[4];
};

std::vector<Tet> tets() {
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 0.1);
  std::vector<Tet> out(kRound);
  for (Tet& t : out) {
    t = {{{0, 0, 0}, {1, 0, 0}, {0.5, 0.866, 0}, {0.5, 0.289, 0.816}}};
    for (Vector3d& p : t.p)
      for (int k = 0; k < 3; ++k) p[k] += normal(random);
  }
  return out;
}

void energy_value(benchmark::State& state) {
  const auto T = tets();
  for (auto _ : state)
    for (const Tet& t : T) benchmark::DoNotOptimize(shape_energy(t.p[0], t.p[1], t.p[2], t.p[3], 1, 0.01));
  state.SetItemsProcessed(state.iterations() * kRound);
}

void energy_hessian(benchmark::State& state) {
  const auto T = tets();
  TetEnergy e;
  for (auto _ : state)
    for (const Tet& t : T) {
      benchmark::DoNotOptimize(shape_energy(t.p[0], t.p[1], t.p[2], t.p[3], 1, 0.01, e));
      benchmark::DoNotOptimize(e.hessian(0, 0));
    }
  state.SetItemsProcessed(state.iterations() * kRound);
}

// The gradient alone, by central differences of the value.
void energy_gradient_by_differences(benchmark::State& state) {
  auto T = tets();
  double worst = 0;
  for (auto _ : state)
    for (Tet& t : T) {
      Eigen::Matrix<double, 12, 1> g;
      for (int i = 0; i < 12; ++i) {
        constexpr double h = 1e-6;
        double& x = t.p[i / 3][i % 3];
        const double x0 = x;
        x = x0 + h;
        const double up = shape_energy(t.p[0], t.p[1], t.p[2], t.p[3], 1, 0.01);
        x = x0 - h;
        g[i] = (up - shape_energy(t.p[0], t.p[1], t.p[2], t.p[3], 1, 0.01)) / (2 * h);
        x = x0;
      }
      benchmark::DoNotOptimize(g);
      if (&t == T.data()) {
        TetEnergy e;
        shape_energy(t.p[0], t.p[1], t.p[2], t.p[3], 1, 0.01, e);
        worst = (e.gradient - g).cwiseAbs().maxCoeff();
      }
    }
  state.SetItemsProcessed(state.iterations() * kRound);
  state.counters["difference"] = worst;
  if (worst > 1e-6) state.SkipWithError("the gradients differ");
}

BENCHMARK(rotation_overtet)->Name("rotation/overtet")->Arg(0)->Arg(1);
BENCHMARK(rotation_svd)->Name("rotation/eigen_jacobi_svd")->Arg(0)->Arg(1);
BENCHMARK(energy_value)->Name("tet_energy/value");
BENCHMARK(energy_hessian)->Name("tet_energy/gradient_and_hessian");
BENCHMARK(energy_gradient_by_differences)->Name("tet_energy/gradient_by_differences");

}  // namespace

BENCHMARK_MAIN();
