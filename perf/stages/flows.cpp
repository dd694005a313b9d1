// Measures the forward and the reverse flow on surface files: one line per model.
//
//   perf_flows [--threads N] [--time S] [--staged] [--small] [--global] [--bisections N] [--growth G] [--lock
//   N]
//   [--paper] [--ladder] [--save DIR] FILE...
//
// Columns: faces, intersecting pairs, forward seconds / steps / attempts / weights, frozen part of the area,
// reverse seconds / iterations / most contacts / halvings / held vertices, area ratios 1 % / 50 % / 99 %,
// edge ratios, part of the faces within 20 %, smallest area ratio.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "kernels/contact/contact.h"
#include "kernels/parallel/parallel.h"
#include "overtet/io.h"
#include "src/forward_flow/forward_flow.h"
#include "src/reverse_flow/reverse_flow.h"

namespace {

using Clock = std::chrono::steady_clock;
double since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

struct Settings {
  int threads = 0;
  double time = 600, growth = overtet::ReverseFlowOptions().growth;
  int rung = 0, extra = 0;
  int lock = overtet::ReverseFlowOptions().lock_iterations;
  int bisections = overtet::ForwardFlowOptions().bisections;
  bool staged = false, global = false, paper = false, ladder = false, small = false, verbose = false;
  std::string save;
};

// Returns the area ratio of the worst 1 %, or -1.
double run(const std::string& name, const overtet::Surface& surface,
           const std::vector<std::array<overtet::Index, 2>>& pairs,
           const overtet::ForwardFlowOptions& forward_options,
           const overtet::ReverseFlowOptions& reverse_options, const Settings& settings, bool& locked) {
  using namespace overtet;
  RunContext context;
  context.threads = settings.threads;
  context.deadline = Clock::now() + std::chrono::milliseconds(static_cast<long>(1000 * settings.time));
  if (settings.verbose)
    context.progress = [](std::string_view stage, double fraction, std::string_view detail) {
      std::printf("  %.*s %.4f %.*s\n", static_cast<int>(stage.size()), stage.data(), fraction,
                  static_cast<int>(detail.size()), detail.data());
    };
  const auto t0 = Clock::now();
  auto forward = forward_flow(surface, pairs, forward_options, context);
  const double forward_s = since(t0);
  locked = true;
  if (!forward) {
    std::printf("%-24s %7ld %6zu  forward %.2f s: %s\n", name.c_str(), static_cast<long>(surface.F.rows()),
                pairs.size(), forward_s, forward.error().message.c_str());
    return -1;
  }
  const ForwardFlowResult& f = forward.value();
  if (settings.verbose)
    for (const auto& s : f.steps)
      std::printf("  attempt %d step %d %s delta %.1e active %d pairs %d%s\n", s.attempt, s.step,
                  to_string(s.weights), s.delta, s.active, s.pairs, s.all_pairs ? "" : "+");
  if (const auto ok = check_postconditions(surface, f); !ok)
    std::printf("  BROKEN %s\n", ok.error().message.c_str());
  std::vector<VertexMatrix> stages;
  if (reverse_options.staged)
    for (std::size_t i = 0; i < f.states.size(); ++i) stages.push_back(f.state(surface.V, i));
  const auto t1 = Clock::now();
  auto reverse = reverse_flow(surface, f.V, stages, f.reverse_free, reverse_options, context);
  const double reverse_s = since(t1);
  std::printf("%-24s %7ld %6zu  fwd %6.2f s %3zu st %2d att %-9.9s frz %3.0f%%", name.c_str(),
              static_cast<long>(surface.F.rows()), pairs.size(), forward_s, f.steps.size(), f.attempts,
              to_string(f.weights), 100 * f.frozen_area);
  if (!reverse) {
    std::printf("  reverse %.2f s: %s\n", reverse_s, reverse.error().message.c_str());
    return -1;
  }
  const ReverseFlowResult& r = reverse.value();
  if (const auto ok = check_postconditions(surface, f.reverse_free, r); !ok)
    std::printf("  BROKEN %s\n", ok.error().message.c_str());
  int halvings = 0;
  Index contacts = 0;
  for (const auto& s : r.steps) halvings += s.halvings, contacts = std::max(contacts, s.contacts);
  const FlowQuality& q = r.quality;
  std::printf(
      "  rev %6.2f s %4d it %6d ct %4d hv %4d held  area %.3f %.3f %.3f edge %.3f %.3f %.3f in20 %.3f worst "
      "%.4f%s\n",
      reverse_s, r.iterations, contacts, halvings, r.rollbacks, q.area_p01, q.area_p50, q.area_p99,
      q.edge_p01, q.edge_p50, q.edge_p99, q.area_within_20, r.worst_face, r.locked ? " LOCKED" : "");
  if (settings.verbose)
    for (const auto& s : r.steps)
      std::printf("  stage %d it %d contacts %d energy %.6g move %.3g halvings %d held %d at %.3f s\n",
                  s.stage, s.iteration, s.contacts, s.energy, s.move, s.halvings, s.held, s.seconds);
  if (!settings.save.empty()) {
    const std::filesystem::path dir(settings.save);
    if (!write_surface(dir / (name + "_forward.ply"), {f.V, surface.F}, SurfaceFormat::ply) ||
        !write_surface(dir / (name + "_u0.ply"), {r.U0, surface.F}, SurfaceFormat::ply))
      std::printf("  not saved\n");
  }
  std::fflush(stdout);
  locked = r.locked;
  return q.area_p01;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace overtet;
  Settings settings;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    if (a == "--threads" && i + 1 < argc)
      settings.threads = std::atoi(argv[++i]);
    else if (a == "--time" && i + 1 < argc)
      settings.time = std::atof(argv[++i]);
    else if (a == "--save" && i + 1 < argc)
      settings.save = argv[++i];
    else if (a == "--staged")
      settings.staged = true;
    else if (a == "--small")
      settings.small = true;
    else if (a == "--bisections" && i + 1 < argc)
      settings.bisections = std::atoi(argv[++i]);
    else if (a == "--rung" && i + 1 < argc)
      settings.rung = std::atoi(argv[++i]);
    else if (a == "--extra" && i + 1 < argc)
      settings.extra = std::atoi(argv[++i]);
    else if (a == "--lock" && i + 1 < argc)
      settings.lock = std::atoi(argv[++i]);
    else if (a == "--growth" && i + 1 < argc)
      settings.growth = std::atof(argv[++i]);
    else if (a == "--global")
      settings.global = true;
    else if (a == "--paper")
      settings.paper = true;
    else if (a == "--ladder")
      settings.ladder = true;
    else if (a == "--verbose")
      settings.verbose = true;
    else
      files.push_back(a);
  }
  for (const std::string& file : files) {
    auto surface = read_surface(file);
    const std::string name = std::filesystem::path(file).stem();
    if (!surface) {
      std::printf("%s: %s\n", name.c_str(), surface.error().message.c_str());
      continue;
    }
    const Surface& s = surface.value();
    const ScopedThreads threads(settings.threads);
    ContactMesh mesh(s.V, s.F, std::vector<char>(s.V.rows(), 1));
    std::vector<std::array<Index, 2>> pairs;
    for (const IndexPair& p : mesh.intersections(s.V)) pairs.push_back({p.a, p.b});
    auto forward = forward_flow_ladder();
    auto reverse = reverse_flow_ladder();
    if (settings.paper) forward = {paper_forward_flow()}, reverse = {paper_reverse_flow()};
    if (settings.rung > 0 && settings.rung <= static_cast<int>(forward.size()))
      forward = {forward[settings.rung - 1]}, reverse = {reverse[settings.rung - 1]};
    if (!settings.ladder) forward.resize(1), reverse.resize(1);
    if (settings.small) forward[0] = forward_flow_ladder()[1];
    for (auto& o : forward) o.bisections = settings.bisections, o.extra_steps += settings.extra;
    for (auto& o : reverse) o.growth = settings.growth, o.lock_iterations = settings.lock;
    if (settings.global) forward[0].regional = false;
    if (settings.staged) reverse[0].staged = true;
    bool locked = true;
    for (std::size_t i = 0; i < forward.size() && locked; ++i)
      run(name, s, pairs, forward[i], reverse[i], settings, locked);
  }
  return 0;
}
