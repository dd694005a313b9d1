// What a flow does in every step: the contact search beside brute force (on a small surface, same number of
// contacts or the benchmark fails), the check of a step, the exact intersections, and the local step of the
// ARAP energy. One thread.
#include <cmath>
#include <set>

#include "kernels/arap/arap.h"
#include "kernels/contact/contact.h"
#include "kernels/laplacian/laplacian.h"
#include "kernels/parallel/parallel.h"
#include "perf/micro/models.h"
#include "tests/support/flow_surfaces.h"

namespace {

using namespace overtet;
using perf::count;

double mean_edge(const Surface& s) {
  return std::sqrt(surface_area(s.V, s.F) / static_cast<double>(s.F.rows()));
}

ContactMesh contact_mesh(const Surface& s) {
  return ContactMesh(s.V, s.F, std::vector<char>(s.V.rows(), 1), s.V,
                     Eigen::VectorXd::Constant(s.V.rows(), mean_edge(s)));
}

void intersections(benchmark::State& state, const Surface& s) {
  const ScopedThreads one(1);
  ContactMesh mesh = contact_mesh(s);
  std::size_t pairs = 0;
  for (auto _ : state) pairs = mesh.intersections(s.V).size();
  count(state, "pairs", static_cast<double>(pairs));
}

// Everything is searched anew.
void first_search(benchmark::State& state, const Surface& s) {
  const ScopedThreads one(1);
  std::size_t contacts = 0;
  for (auto _ : state) {
    state.PauseTiming();
    ContactMesh mesh = contact_mesh(s);
    state.ResumeTiming();
    contacts = mesh.find_contacts(s.V).size();
  }
  count(state, "contacts", static_cast<double>(contacts));
}

// Pairs remembered, as in the late iterations of a reverse flow.
void next_search(benchmark::State& state, const Surface& s) {
  const ScopedThreads one(1);
  ContactMesh mesh = contact_mesh(s);
  std::size_t contacts = mesh.find_contacts(s.V).size();
  for (auto _ : state) contacts = mesh.find_contacts(s.V).size();
  count(state, "contacts", static_cast<double>(contacts));
}

// A long step: swept boxes, no memory.
void check_step(benchmark::State& state, const Surface& s) {
  const ScopedThreads one(1);
  ContactMesh mesh = contact_mesh(s);
  const VertexMatrix P = 0.05 * s.V;
  std::size_t hits = 0;
  for (auto _ : state) hits = mesh.check_step(s.V, P).size();
  count(state, "hits", static_cast<double>(hits));
}

void arap_step(benchmark::State& state, const Surface& s) {
  const ScopedThreads one(1);
  Arap arap(s.V, s.F);
  VertexMatrix G;
  for (auto _ : state) {
    arap.fit_rotations(s.V);
    arap.gradient(s.V, G);
  }
}

// Every vertex against every triangle, every edge against every edge.
std::size_t all_contacts(const Surface& s, double h) {
  const ContactRule rule;
  std::set<std::pair<Index, Index>> edges;
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Index a = s.F(f, k), b = s.F(f, (k + 1) % 3);
      edges.insert({std::min(a, b), std::max(a, b)});
    }
  const auto adjacent = [&](Index a, Index b) { return edges.contains({std::min(a, b), std::max(a, b)}); };
  std::size_t found = 0;
  const auto look = [&](PairKind kind, const std::array<Index, 4>& v, int split) {
    std::array<Eigen::Vector3d, 4> x;
    for (int i = 0; i < 4; ++i) x[i] = s.V.row(v[i]);
    const double distance = closest_points(kind, x).distance;
    if (distance >= std::max(rule.reach, rule.ring_floor) * h) return;
    bool near = false;
    for (int a = 0; a < split; ++a)
      for (int b = split; b < 4; ++b) near = near || adjacent(v[a], v[b]);
    const double dhat =
        near ? std::max(std::min(rule.reach * h, rule.ring_reach * distance), rule.ring_floor * h)
             : rule.reach * h;
    found += distance < dhat;
  };
  for (Index v = 0; v < s.V.rows(); ++v)
    for (Index f = 0; f < s.F.rows(); ++f) {
      const Index a = s.F(f, 0), b = s.F(f, 1), c = s.F(f, 2);
      if (v != a && v != b && v != c) look(PairKind::vertex_triangle, {v, a, b, c}, 1);
    }
  for (auto e = edges.begin(); e != edges.end(); ++e)
    for (auto g = std::next(e); g != edges.end(); ++g)
      if (e->first != g->first && e->first != g->second && e->second != g->first && e->second != g->second)
        look(PairKind::edge_edge, {e->first, e->second, g->first, g->second}, 2);
  return found;
}

const Surface& small() {
  static const Surface s = test::bent_capsule(330, 1, 0.3, 40, 14);
  return s;
}

void small_search(benchmark::State& state) { first_search(state, small()); }

void brute_force(benchmark::State& state) {
  const Surface& s = small();
  std::size_t contacts = 0;
  for (auto _ : state) contacts = all_contacts(s, mean_edge(s));
  count(state, "contacts", static_cast<double>(contacts));
  if (contacts != contact_mesh(s).find_contacts(s.V).size())
    state.SkipWithError("brute force finds another number");
}

void register_all() {
  benchmark::RegisterBenchmark("contact/overtet/small", small_search)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("contact/brute_force/small", brute_force)->Unit(benchmark::kMillisecond);
  perf::for_each_model("contact/first_search", first_search);
  perf::for_each_model("contact/next_search", next_search);
  perf::for_each_model("contact/check_step", check_step);
  perf::for_each_model("contact/intersections", intersections);
  perf::for_each_model("arap/step", arap_step);
}

}  // namespace

int main(int argc, char** argv) { return overtet::perf::run(argc, argv, register_all); }
