#include "src/improve/improve.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "kernels/parallel/parallel.h"
#include "src/improve/passes.h"
#include "src/improve/refine.h"
#include "src/tet_complex/local_operations.h"
#include "src/tet_complex/parts.h"

namespace overtet {

namespace {

constexpr int kMostParts = 256;  // enough for many threads; every cut costs a little
// Refinement makes do with two: where nothing is inside yet, tets reach from one side to the other, and what
// more cuts leave in between costs more than they save.
constexpr int kRefineParts = 2;
// What lies around a place: so many layers of tets. Vertices with more tets than this do not spread it.
constexpr int kLayers = 2;
constexpr int kLargestStar = 80;
// The next round around cuts is the last one when it has more than this part of the tets of the one before.
constexpr double kShrinks = 0.75;
// Tets below this part of the target angle are looked at once more after the cuts, with all that is around
// them. Those within a factor of the very worst are after that, by all means, as long as that lifts it.
constexpr double kLookAgain = 0.5;
constexpr double kWorstOfAll = 1.5;
constexpr double kLookPays = 1.05;
constexpr int kMostLooks = 8;
constexpr std::int64_t kTetsPerLook = 2000;  // in a part, at least
// Refinement may at most multiply the tets by this.
constexpr std::int64_t kRefinedGrowth = 5;
// Below this smallest dihedral sine (3 degrees) vertices inside are taken out where that helps.
constexpr double kLooseQuality = 0.05;
constexpr std::int64_t kGrain = 4096;  // tets

int parts_for(std::size_t tets, std::int64_t tets_per_part) {
  int parts = 1;
  while (parts < kMostParts && static_cast<std::int64_t>(tets) / (2 * parts) >= tets_per_part) parts *= 2;
  return parts;
}

enum class Work { refine, passes, both, look };

struct PartResult {
  std::int64_t refined = 0;
  PassesResult passes;
};

// loose: of the whole mesh's vertices, see refine().
PartResult improve_part(MeshPart& part, Work what, std::span<const char> loose, const ImproveOptions& options,
                        double seconds, const RunContext& context) {
  PartResult result;
  LocalOperations work(part.complex);
  part.mark_shared(work);
  if ((what == Work::refine || what == Work::both) && options.radius_edge > 0) {
    std::vector<char> here;
    for (const Index v : part.vertex) here.push_back(loose[v]);
    contract_loose(work, here, kLooseQuality, context);
    result.refined =
        refine(work, options.radius_edge, here, kRefinedGrowth * part.complex.tet_count() + 1000, context);
  }
  if (what != Work::refine)
    result.passes = improve_passes(work, options, what == Work::look, seconds, context);
  return result;
}

// Several threads may mark the same vertex.
void mark(char& c) { std::atomic_ref(c).store(1, std::memory_order_relaxed); }

// Marks the corners of the tets that are `bad`.
template <class Bad>
std::vector<char> corners_of(const TetMesh& mesh, Bad&& bad) {
  std::vector<char> marked(static_cast<std::size_t>(mesh.V.rows()), 0);
  parallel_for(mesh.T.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (Index t = static_cast<Index>(begin); t < end; ++t)
      if (bad(t))
        for (int k = 0; k < 4; ++k) mark(marked[mesh.T(t, k)]);
  });
  return marked;
}

// The tets within kLayers layers around some vertices.
std::vector<Index> around(const TetMesh& mesh, std::vector<char> near) {
  std::vector<int> star(near.size(), 0);
  parallel_for(mesh.T.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t)
      for (int k = 0; k < 4; ++k) std::atomic_ref(star[mesh.T(t, k)]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::size_t v = 0; v < near.size(); ++v)
    if (star[v] > kLargestStar) near[v] = 0;
  std::vector<char> chosen(static_cast<std::size_t>(mesh.T.rows()), 0);
  for (int layer = 0; layer < kLayers; ++layer) {
    parallel_for(mesh.T.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t t = begin; t < end; ++t)
        for (int k = 0; k < 4; ++k)
          if (near[mesh.T(t, k)]) chosen[t] = 1;
    });
    if (layer + 1 < kLayers)
      parallel_for(mesh.T.rows(), kGrain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t t = begin; t < end; ++t)
          if (chosen[t])
            for (int k = 0; k < 4; ++k)
              if (const Index v = mesh.T(t, k); star[v] <= kLargestStar) mark(near[v]);
      });
  }
  std::vector<Index> tets;
  for (Index t = 0; t < mesh.T.rows(); ++t)
    if (chosen[t]) tets.push_back(t);
  return tets;
}

double quality(const TetMesh& mesh, Index t) {
  return min_dihedral_sine(mesh.V.row(mesh.T(t, 0)), mesh.V.row(mesh.T(t, 1)), mesh.V.row(mesh.T(t, 2)),
                           mesh.V.row(mesh.T(t, 3)));
}

double radius_edge(const TetMesh& mesh, Index t) {
  return std::sqrt(squared_radius_edge(mesh.V.row(mesh.T(t, 0)), mesh.V.row(mesh.T(t, 1)),
                                       mesh.V.row(mesh.T(t, 2)), mesh.V.row(mesh.T(t, 3))));
}

double sine_of(double degrees) { return std::sin(degrees * M_PI / 180); }

double worst_quality(const TetMesh& mesh) {
  return parallel_reduce(
      mesh.T.rows(), kGrain, 1.0,
      [&](std::int64_t begin, std::int64_t end) {
        double worst = 1;
        for (Index t = static_cast<Index>(begin); t < end; ++t) worst = std::min(worst, quality(mesh, t));
        return worst;
      },
      [](double x, double y) { return std::min(x, y); });
}

// Corners of the tets at shared vertices that are still to be worked on.
std::vector<char> unfinished(const TetMesh& mesh, std::span<const char> shared, Work what,
                             const ImproveOptions& options) {
  const double target = sine_of(options.target_degrees);
  return corners_of(mesh, [&](Index t) {
    bool at_cut = false;
    for (int k = 0; k < 4; ++k) at_cut = at_cut || shared[mesh.T(t, k)];
    return at_cut &&
           (what == Work::refine ? radius_edge(mesh, t) > options.radius_edge : quality(mesh, t) < target);
  });
}

// As halve(), but tets with a common vertex are in the same part.
std::vector<int> in_pieces(const TetMesh& mesh, std::span<const Index> chosen, int parts) {
  std::vector<int> part_of = halve(mesh, chosen, parts);
  std::vector<Index> up(static_cast<std::size_t>(mesh.V.rows()));
  std::iota(up.begin(), up.end(), 0);
  const auto root = [&](Index v) {
    while (up[v] != v) v = up[v] = up[up[v]];
    return v;
  };
  for (const Index t : chosen)
    for (int k = 1; k < 4; ++k) up[root(mesh.T(t, k))] = root(mesh.T(t, 0));
  std::vector<int> part(up.size(), -1);  // of a piece, by its root: the part of its first tet
  for (const Index t : chosen) {
    int& p = part[root(mesh.T(t, 0))];
    if (p < 0) p = part_of[t];
    part_of[t] = p;
  }
  return part_of;
}

void add(ImproveResult& sum, const PartResult& part, std::size_t first_pass) {
  sum.end = std::max(sum.end, part.passes.end);
  sum.refined += part.refined;
  const auto& passes = part.passes.passes;
  if (sum.passes.size() < first_pass + passes.size()) sum.passes.resize(first_pass + passes.size());
  for (std::size_t i = 0; i < passes.size(); ++i) {
    ImprovePass& to = sum.passes[first_pass + i];
    to.worst_sine = to.bad == 0 ? passes[i].worst_sine : std::min(to.worst_sine, passes[i].worst_sine);
    to.bad += passes[i].bad;
    to.removed_edges += passes[i].removed_edges;
    to.flips += passes[i].flips;
    to.smoothed += passes[i].smoothed;
    to.collapsed += passes[i].collapsed;
    to.inserted += passes[i].inserted;
    to.seconds += passes[i].seconds;
  }
}

}  // namespace

Status ImproveOptions::validate() const {
  if (radius_edge != 0 && !(radius_edge >= 1.2 && radius_edge <= 100))
    return Error{ErrorCode::usage, "The radius-edge bound must lie between 1.2 and 100, or be 0 for none."};
  if (!(target_degrees > 0 && target_degrees <= 40))
    return Error{ErrorCode::usage, "The target angle must lie between 0 and 40 degrees."};
  if (!(insert_below_degrees >= 0 && insert_below_degrees <= 40))
    return Error{ErrorCode::usage,
                 "The angle below which vertices are inserted must lie between 0 and 40 degrees."};
  if (!(growth >= 1)) return Error{ErrorCode::usage, "The allowed growth of the mesh must be at least 1."};
  if (passes < 0) return Error{ErrorCode::usage, "The number of passes must not be negative."};
  if (!(effort >= 0)) return Error{ErrorCode::usage, "The effort of the quality pass must not be negative."};
  if (tets_per_part < 1) return Error{ErrorCode::usage, "A part of the mesh must have a tet at least."};
  if (!(seconds >= 0)) return Error{ErrorCode::usage, "The time for the quality pass must not be negative."};
  return success();
}

Result<ImproveResult> improve(TetMesh& mesh, const ImproveOptions& options, const RunContext& context) {
  if (auto status = options.validate(); !status.ok()) return status.error();
  if (auto error = context.stop()) return *error;
  const auto begin = RunContext::Clock::now();
  const auto since_begin = [&] {
    return std::chrono::duration<double>(RunContext::Clock::now() - begin).count();
  };
  const double budget = std::min(options.seconds, 0.5 * context.seconds_left());
  RunContext silent = context;
  silent.progress = nullptr;

  ImproveResult result;
  result.before = dihedral_statistics(mesh.V, mesh.T);
  std::vector<char> loose(static_cast<std::size_t>(mesh.V.rows()), 1);  // the inside's, as given
  std::fill(loose.begin(), loose.begin() + mesh.surface_vertices, 0);

  // One round: all parts at the same time. Returns the vertices that several parts shared.
  const auto round = [&](Work what, const std::vector<int>& part_of, int count) {
    const std::size_t first_pass = result.passes.size();
    std::vector<MeshPart> parts = take_parts(mesh, part_of, count);
    std::vector<PartResult> results(parts.size());
    const double seconds = std::max(0.0, budget - since_begin());
    parallel_for(count, 1, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t p = first; p < last; ++p)
        results[p] = improve_part(parts[p], what, loose, options, seconds, silent);
    });
    for (const PartResult& part : results) add(result, part, first_pass);
    result.rounds.push_back(count);
    std::vector<char> times_shared(static_cast<std::size_t>(mesh.V.rows()), 0);
    for (const MeshPart& part : parts)
      for (const Index v : part.shared)
        if (char& times = times_shared[part.vertex[v]]; times < 2) ++times;
    const std::vector<Index> number = put_parts(mesh, part_of, parts);
    std::vector<char> shared(static_cast<std::size_t>(mesh.V.rows()), 0), still_loose(shared.size(), 0);
    for (std::size_t v = 0; v < number.size(); ++v) {
      if (number[v] < 0) continue;
      shared[number[v]] = times_shared[v] > 1;
      still_loose[number[v]] = loose[v];
    }
    loose = std::move(still_loose);
    return shared;
  };
  // All tets, then what is unfinished around the cuts, until that is in one part. most_parts: in a round.
  const auto rounds = [&](Work what, int most_parts) {
    std::vector<Index> chosen(static_cast<std::size_t>(mesh.T.rows()));
    std::iota(chosen.begin(), chosen.end(), 0);
    while (!chosen.empty()) {
      const int count = std::min(most_parts, parts_for(chosen.size(), options.tets_per_part));
      context.report("improve",
                     what == Work::refine       ? 0
                     : result.rounds.size() < 3 ? 0.3
                                                : 0.8,
                     std::to_string(chosen.size()) + " tets in " + std::to_string(count) + " parts");
      const std::vector<char> shared = round(what, halve(mesh, chosen, count), count);
      if (count == 1 || context.stop()) return;
      const auto before = static_cast<double>(chosen.size());
      chosen = around(mesh, unfinished(mesh, shared, what, options));
      if (static_cast<double>(chosen.size()) > kShrinks * before) return;
      if (what == Work::refine) most_parts = 1;
    }
  };
  const bool cut = parts_for(static_cast<std::size_t>(mesh.T.rows()), options.tets_per_part) > 1;
  if (cut && options.radius_edge > 0) rounds(Work::refine, kRefineParts);
  rounds(cut ? Work::passes : Work::both, kMostParts);

  // Bad tets wherever they are, with all that is around them.
  const auto look_at = [&](Work what, double sine) {
    const std::vector<Index> chosen =
        around(mesh, corners_of(mesh, [&](Index t) { return quality(mesh, t) < sine; }));
    const int count = parts_for(chosen.size(), kTetsPerLook);
    if (!chosen.empty() && !context.stop()) round(what, in_pieces(mesh, chosen, count), count);
  };
  if (cut) look_at(Work::passes, sine_of(kLookAgain * options.target_degrees));
  double worst = worst_quality(mesh);
  const double target = sine_of(options.target_degrees);
  for (int look = 0; look < kMostLooks && worst < target; ++look) {
    look_at(Work::look, std::min(target, kWorstOfAll * worst));
    const double before = worst;
    worst = worst_quality(mesh);
    if (!(worst > kLookPays * before)) break;
  }
  if (context.cancel && context.stop()) return *context.stop();
  result.after = dihedral_statistics(mesh.V, mesh.T);
  result.seconds = since_begin();
  return result;
}

}  // namespace overtet
