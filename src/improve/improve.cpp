#include "src/improve/improve.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <numeric>

#include "kernels/parallel/parallel.h"
#include "src/improve/passes.h"
#include "src/improve/refine.h"
#include "src/improve/trade.h"
#include "src/improve/worst_places.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/partition.h"

namespace overtet {

namespace {

// Enough for many threads; every cut costs a little. A mesh that is cut at all is cut for the passes into so
// many parts at least: what they cost is known only afterwards, and a thread that is done early finds another
// one.
constexpr int kMostParts = 256, kLeastParts = 8;
// Where more than this share of the tets is bad, cuts leave too much undone: fewer, larger parts then.
constexpr double kMostlyBad = 0.5;
// In a round around cuts, and in a look: tets in a part, at least.
constexpr std::int64_t kTetsAroundCuts = 3000, kTetsPerLook = 500;
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
// Where too many tets are bad, some may fall to this part of what is good. Then those below another part are
// raised again, as far as that makes hardly any others bad: that much more they cost.
constexpr double kMayFallTo = 0.47, kRaiseTo = 0.63, kSteep = 5;
// All this leaves about half of the bad tets. Where there are so many times too many, it is not tried; where
// it leaves too many, nothing has been gained by giving some up: it is not done then.
constexpr double kHopeless = 2.5;
// Of the goal, so that rounding does not matter; and of the share, as percentiles are interpolated.
constexpr double kABitMore = 1.0005, kABitLess = 0.998;
// What a tet that has to be worked on costs, in tets that have not.
constexpr int kBadTetWeight = 15, kBadToRefineWeight = 10;
// Where what hangs together makes parts that differ by less than this factor nothing is cut.
constexpr double kUneven = 1.3;
// Cuts may be so far from where they give even parts. Of two parts one thread waits for the other.
constexpr double kSlack = 0.15, kSlackForTwo = 0.03;
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

// For what is shared out without a cut.
int pieces_for(std::size_t tets) { return std::min(kLeastParts, parts_for(tets, kTetsPerLook)); }

enum class Work { refine, passes, both, look, trade, raise };

struct PartResult {
  std::int64_t refined = 0, traded = 0;
  PassesResult passes;
};

// loose: of the whole mesh's vertices, see refine(). fresh: the same, see improve_passes(); empty: all.
PartResult improve_part(MeshPart& part, Work what, std::span<const char> loose, std::span<const char> fresh,
                        const ImproveOptions& options, const LocalOperations::Price& price, double seconds,
                        const RunContext& context) {
  PartResult result;
  LocalOperations work(part.complex);
  part.mark_shared(work);
  if (what == Work::trade || what == Work::raise) {
    result.traded = fewer_bad(work, price, what == Work::trade, context);
    return result;
  }
  const auto here = [&](std::span<const char> all) {
    std::vector<char> of_part;
    if (!all.empty())
      for (const Index v : part.vertex) of_part.push_back(all[v]);
    return of_part;
  };
  if ((what == Work::refine || what == Work::both) && options.radius_edge > 0) {
    const std::vector<char> loose_here = here(loose);
    contract_loose(work, loose_here, kLooseQuality, context);
    result.refined = refine(work, options.radius_edge, loose_here,
                            kRefinedGrowth * part.complex.tet_count() + 1000, context);
  }
  if (what != Work::refine)
    result.passes = improve_passes(work, here(fresh), options, what == Work::look, seconds, context);
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

std::int64_t count_below(const TetMesh& mesh, double sine) {
  return parallel_reduce(
      mesh.T.rows(), kGrain, std::int64_t{0},
      [&](std::int64_t begin, std::int64_t end) {
        std::int64_t below = 0;
        for (Index t = static_cast<Index>(begin); t < end; ++t) below += quality(mesh, t) < sine;
        return below;
      },
      std::plus<>());
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

// How the tets are weighed when they are shared out.
std::vector<int> weights(const TetMesh& mesh, std::span<const Index> chosen, Work what,
                         const ImproveOptions& options) {
  const double target = sine_of(options.target_degrees);
  std::vector<int> weight(chosen.size());
  parallel_for(static_cast<std::int64_t>(chosen.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      weight[i] = what == Work::refine
                      ? (radius_edge(mesh, chosen[i]) > options.radius_edge ? kBadToRefineWeight : 1)
                      : (quality(mesh, chosen[i]) < target ? kBadTetWeight : 1);
  });
  return weight;
}

void add(ImproveResult& sum, const PartResult& part, std::size_t first_pass) {
  sum.end = std::max(sum.end, part.passes.end);
  sum.refined += part.refined;
  sum.traded += part.traded;
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
  if (!(good_degrees > 0 && good_degrees <= 40 && bad_share >= 0 && bad_share <= 1))
    return Error{ErrorCode::usage,
                 "The good angle must lie between 0 and 40 degrees, the share of bad tets between 0 and 1."};
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
  // The mesh is to be checked and written in what time is left.
  silent.deadline = std::min(
      context.deadline,
      begin + std::chrono::duration_cast<RunContext::Clock::duration>(std::chrono::duration<double>(budget)));

  ImproveResult result;
  result.before = dihedral_statistics(mesh.V, mesh.T);
  std::vector<char> loose(static_cast<std::size_t>(mesh.V.rows()), 1);  // the inside's, as given
  std::fill(loose.begin(), loose.begin() + mesh.surface_vertices, 0);

  LocalOperations::Price price;  // where fewer tets are to be bad
  // One round: all parts at the same time, the heaviest first. Returns the vertices that several parts
  // shared.
  const auto round = [&](Work what, const std::vector<int>& part_of, int count, std::span<const Index> chosen,
                         std::span<const int> weight, std::span<const char> fresh) {
    const std::size_t first_pass = result.passes.size();
    std::vector<MeshPart> parts = take_parts(mesh, part_of, count);
    std::vector<PartResult> results(parts.size());
    const double seconds = std::max(0.0, budget - since_begin());
    std::vector<std::pair<std::int64_t, int>> order(parts.size());
    for (int p = 0; p < count; ++p) order[p].second = p;
    for (std::size_t i = 0; i < chosen.size(); ++i) order[part_of[chosen[i]]].first -= weight[i];
    std::sort(order.begin(), order.end());
    parallel_tasks(count, [&](std::int64_t i) {
      const int p = order[i].second;
      results[p] = improve_part(parts[p], what, loose, fresh, options, price, seconds, silent);
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
  // All tets, then what is unfinished around the cuts, until nothing was cut.
  const auto rounds = [&](Work what) {
    std::vector<Index> chosen(static_cast<std::size_t>(mesh.T.rows()));
    std::iota(chosen.begin(), chosen.end(), 0);
    std::vector<int> weight = weights(mesh, chosen, what, options);
    std::vector<char> fresh;
    bool mostly_bad = false;
    int count = 1;
    if (what == Work::refine) count = kRefineParts;
    if (what == Work::passes) {
      count = parts_for(chosen.size(), options.tets_per_part);
      const auto bad = static_cast<double>(std::count(weight.begin(), weight.end(), kBadTetWeight));
      mostly_bad = bad >= kMostlyBad * static_cast<double>(chosen.size());
      if (!mostly_bad) count = std::max(kLeastParts, count);
    }
    const double slack = count == kRefineParts ? kSlackForTwo : kSlack;
    while (!chosen.empty()) {
      context.report("improve",
                     what == Work::refine       ? 0
                     : result.rounds.size() < 3 ? 0.3
                                                : 0.8,
                     std::to_string(chosen.size()) + " tets in " + std::to_string(count) + " parts");
      const bool last = count == 1;
      // Nothing is cut any more, but in the passes what does not hang together is shared out.
      if (last && what == Work::passes && !fresh.empty() && !mostly_bad) count = pieces_for(chosen.size());
      Pieces pieces;
      if (!fresh.empty()) pieces = in_pieces(mesh, chosen, count, weight);
      if (fresh.empty() || (!last && pieces.uneven > kUneven))
        pieces.part_of = cut_apart(mesh, chosen, count, slack, weight);
      fresh = round(what, pieces.part_of, count, chosen, weight, fresh);
      if (last || silent.stop()) return;
      const auto before = static_cast<double>(chosen.size());
      chosen = around(mesh, unfinished(mesh, fresh, what, options));
      if (static_cast<double>(chosen.size()) > kShrinks * before) return;
      // Fewer, so that the cuts are not where they were before.
      count = std::min(count, parts_for(chosen.size(), kTetsAroundCuts)) / 2 + 1;
      if (what == Work::refine || count == 2) count = 1;
      weight = weights(mesh, chosen, what, options);
    }
  };
  const bool cut = parts_for(static_cast<std::size_t>(mesh.T.rows()), options.tets_per_part) > 1;
  if (cut && options.radius_edge > 0) rounds(Work::refine);
  rounds(cut ? Work::passes : Work::both);

  // Bad tets wherever they are, with all that is around them.
  const auto look_at = [&](Work what, double sine) {
    const std::vector<Index> chosen =
        around(mesh, corners_of(mesh, [&](Index t) { return quality(mesh, t) < sine; }));
    const int count = pieces_for(chosen.size());
    if (chosen.empty() || silent.stop()) return;
    const std::vector<int> weight = weights(mesh, chosen, what, options);
    round(what, in_pieces(mesh, chosen, count, weight).part_of, count, chosen, weight, {});
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
  if (!silent.stop()) result.lifted = lift_worst(mesh, target, silent);
  // Lifting has numbered vertices anew, and only refinement asks.
  loose.assign(static_cast<std::size_t>(mesh.V.rows()), 0);

  // Too many bad ones: fewer, be they worse. What is good enough for the target is good.
  const double good = sine_of(std::min(options.good_degrees, options.target_degrees));
  const auto times_too_many = [&] {
    return static_cast<double>(count_below(mesh, good)) /
           (kABitLess * options.bad_share * static_cast<double>(mesh.T.rows()));
  };
  const double too_many = times_too_many();
  bool traded = false;
  if (too_many > 1 && too_many < kHopeless && !silent.stop()) {
    const TetMesh before = mesh;
    price.goal = kABitMore * good;
    price.low = kMayFallTo * good;
    look_at(Work::trade, price.goal);
    price.low = kRaiseTo * good;
    price.steep = kSteep;
    look_at(Work::raise, price.goal);
    traded = times_too_many() <= 1;
    if (!traded) {
      mesh = before;
      loose.assign(static_cast<std::size_t>(mesh.V.rows()), 0);
      result.traded = 0;
    }
  }
  if (!traded && result.lifted > 0) look_at(Work::passes, sine_of(kLookAgain * options.target_degrees));
  if (context.cancel && context.stop()) return *context.stop();
  result.after = dihedral_statistics(mesh.V, mesh.T);
  result.seconds = since_begin();
  return result;
}

}  // namespace overtet
