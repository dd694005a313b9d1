// Exact decisions: this program's predicates beside CGAL's, on points in general position (a floating-point
// filter decides) and on a grid (many are coplanar, exact arithmetic decides). Counter zeros: answers 0, the
// same for both or the benchmark fails.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <benchmark/benchmark.h>

#include <array>
#include <random>
#include <vector>

#include "kernels/predicates/predicates.h"

namespace {

using namespace overtet;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr int kCalls = 4096;

enum Kind { general, grid, near_plane };

// Points of kCalls groups of six.
std::vector<std::array<double, 3>> points(int kind) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  std::uniform_int_distribution<int> cell(0, 4);
  std::vector<std::array<double, 3>> out(6 * kCalls);
  for (auto& p : out) {
    for (double& x : p) x = kind == grid ? cell(random) / 4.0 : unit(random);
    // Rounded points of one plane: the sign hangs on the last bits.
    if (kind == near_plane) p[2] = 0.3 * p[0] + 0.7 * p[1] + 0.1;
  }
  return out;
}

const char* label(int kind) { return kind == general ? "general" : kind == grid ? "grid" : "near_plane"; }

std::vector<Kernel::Point_3> for_cgal(const std::vector<std::array<double, 3>>& from) {
  std::vector<Kernel::Point_3> out;
  for (const auto& p : from) out.emplace_back(p[0], p[1], p[2]);
  return out;
}

void finish(benchmark::State& state, std::int64_t zeros) {
  state.SetItemsProcessed(state.iterations() * kCalls);
  state.counters["zeros"] = static_cast<double>(zeros);
  state.SetLabel(label(static_cast<int>(state.range(0))));
}

void orient3d_overtet(benchmark::State& state) {
  const auto p = points(static_cast<int>(state.range(0)));
  std::int64_t zeros = 0;
  for (auto _ : state) {
    zeros = 0;
    for (int i = 0; i < kCalls; ++i)
      zeros += orient3d(p[6 * i].data(), p[6 * i + 1].data(), p[6 * i + 2].data(), p[6 * i + 3].data()) == 0;
    benchmark::DoNotOptimize(zeros);
  }
  finish(state, zeros);
}

void orient3d_cgal(benchmark::State& state) {
  const auto q = points(static_cast<int>(state.range(0)));
  const auto p = for_cgal(q);
  std::int64_t zeros = 0;
  for (auto _ : state) {
    zeros = 0;
    for (int i = 0; i < kCalls; ++i)
      zeros += CGAL::orientation(p[6 * i], p[6 * i + 1], p[6 * i + 2], p[6 * i + 3]) == CGAL::COPLANAR;
    benchmark::DoNotOptimize(zeros);
  }
  finish(state, zeros);
  for (int i = 0; i < kCalls; ++i)
    if (orient3d(q[6 * i].data(), q[6 * i + 1].data(), q[6 * i + 2].data(), q[6 * i + 3].data()) !=
        CGAL::orientation(p[6 * i], p[6 * i + 1], p[6 * i + 2], p[6 * i + 3])) {
      state.SkipWithError("CGAL answers otherwise");
      return;
    }
}

void triangles_overtet(benchmark::State& state) {
  const auto p = points(static_cast<int>(state.range(0)));
  std::int64_t apart = 0;
  for (auto _ : state) {
    apart = 0;
    for (int i = 0; i < kCalls; ++i)
      apart += !triangles_intersect(p[6 * i].data(), p[6 * i + 1].data(), p[6 * i + 2].data(),
                                    p[6 * i + 3].data(), p[6 * i + 4].data(), p[6 * i + 5].data());
    benchmark::DoNotOptimize(apart);
  }
  finish(state, apart);
}

void triangles_cgal(benchmark::State& state) {
  const auto p = for_cgal(points(static_cast<int>(state.range(0))));
  std::int64_t apart = 0;
  for (auto _ : state) {
    apart = 0;
    for (int i = 0; i < kCalls; ++i)
      apart += !CGAL::do_intersect(Kernel::Triangle_3(p[6 * i], p[6 * i + 1], p[6 * i + 2]),
                                   Kernel::Triangle_3(p[6 * i + 3], p[6 * i + 4], p[6 * i + 5]));
    benchmark::DoNotOptimize(apart);
  }
  finish(state, apart);
}

BENCHMARK(orient3d_overtet)->Name("orient3d/overtet")->Arg(general)->Arg(grid)->Arg(near_plane);
BENCHMARK(orient3d_cgal)->Name("orient3d/cgal")->Arg(general)->Arg(grid)->Arg(near_plane);
// Grid triangles may be flat, which CGAL's test does not allow.
BENCHMARK(triangles_overtet)->Name("triangles/overtet")->Arg(general)->Arg(near_plane);
BENCHMARK(triangles_cgal)->Name("triangles/cgal")->Arg(general)->Arg(near_plane);

}  // namespace

BENCHMARK_MAIN();
