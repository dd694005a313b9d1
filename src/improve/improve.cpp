#include "src/improve/improve.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "kernels/core/assertions.h"
#include "kernels/core/tuning.h"
#include "kernels/parallel/counts.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/improve/bad_tets.h"
#include "src/improve/coarsen.h"
#include "src/improve/layers.h"
#include "src/improve/passes.h"
#include "src/improve/refine.h"
#include "src/improve/round_progress.h"
#include "src/improve/sizes.h"
#include "src/improve/trade.h"
#include "src/improve/tuning.h"
#include "src/improve/worst_places.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/partition.h"

namespace overtet {

namespace {

int parts_for(std::size_t tets, std::int64_t tets_per_part) {
  int parts = 1;
  while (static_cast<std::int64_t>(tets) / (2 * parts) >= tets_per_part) parts *= 2;
  return parts;
}

// For what is shared out without a cut.
int pieces_for(std::size_t tets) { return std::min(kLeastParts, parts_for(tets, kTetsPerLook)); }

double sine_of(double degrees) { return std::sin(degrees * M_PI / 180); }

enum class Work { thin, shrink, shrink_last, coarsen, refine, passes, both, look, trade, raise };

struct PartResult {
  std::int64_t thinned = 0, refined = 0, coarsened = 0, traded = 0;
  PassesResult passes;
  std::vector<LocalSize> sizes;  // of the part's vertices, where they are limited
};

// What all parts are told.
struct Orders {
  Work what;
  // Of the whole mesh's vertices, see refine() and improve_passes(); empty: all are fresh.
  std::span<const char> loose, fresh;
  const ImproveOptions& options;
  const LocalOperations::Price& price;
  const SizeField* sizes;  // null: not limited
  double seconds;
};

void do_work(LocalOperations& work, const MeshPart& part, const Orders& orders, const RunContext& context,
             PartResult& result) {
  const ImproveOptions& options = orders.options;
  const std::int64_t tets = part.complex.tet_count();
  const auto here = [&](std::span<const char> all) {
    std::vector<char> of_part;
    if (!all.empty())
      for (const Index v : part.vertex) of_part.push_back(all[v]);
    return of_part;
  };
  switch (orders.what) {
    case Work::trade:
      result.traded = fewer_bad(work, orders.price, NewVertices::some, context);
      return;
    case Work::raise:
      result.traded = fewer_bad(work, orders.price, NewVertices::none, context);
      return;
    case Work::thin:
      result.thinned = coarsen(work, kThinnedQuality, Removal::by_contraction, context);
      return;
    case Work::coarsen:
      result.coarsened = coarsen(work, sine_of(options.target_degrees), Removal::by_all_means, context);
      return;
    case Work::shrink:
    case Work::shrink_last:
      result.refined = make_small(
          work, orders.what == Work::shrink ? LocalOperations::Splits::roomy : LocalOperations::Splits::all,
          kGrowthOfRound * tets + 1000, context);
      return;
    case Work::refine:
    case Work::both:
      if (options.radius_edge > 0) {
        const std::vector<char> loose = here(orders.loose);
        contract_loose(work, loose, kLooseQuality, context);
        result.refined = refine(work, options.radius_edge, loose,
                                kRefinedGrowth * part.complex.tet_count() + 1000, context);
      }
      if (orders.what == Work::refine) return;
      [[fallthrough]];
    case Work::passes:
    case Work::look:
      result.passes = improve_passes(work, here(orders.fresh), options,
                                     orders.what == Work::look ? Care::by_all_means : Care::usual,
                                     orders.seconds, context);
  }
}

PartResult improve_part(MeshPart& part, const Orders& orders, const RunContext& context) {
  PartResult result;
  LocalOperations work(part.complex);
  part.mark_shared(work);
  if (orders.sizes) work.limit_sizes(orders.sizes->of_part(part));
  do_work(work, part, orders, context, result);
  if (orders.sizes) result.sizes = work.limit()->sizes;
  return result;
}

// Marks the corners of the tets that are `bad`.
template <class Bad>
std::vector<char> corners_of(const TetMesh& mesh, Bad&& bad) {
  std::vector<char> marked(static_cast<std::size_t>(mesh.V.rows()), 0);
  count(Count::touched_tets, mesh.T.rows());
  parallel_for(mesh.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (Index t = static_cast<Index>(begin); t < end; ++t)
      if (bad(t))
        for (int k = 0; k < 4; ++k) mark(marked[mesh.T(t, k)]);
  });
  return marked;
}

// The tets within kLayers layers around some vertices, none of which has too many tets.
std::vector<Index> around(const TetMesh& mesh, std::vector<char> near) {
  const std::vector<int> star = star_sizes(mesh);
  for (std::size_t v = 0; v < near.size(); ++v)
    if (star[v] > kLargestStar) near[v] = 0;
  const std::vector<char> chosen = within_layers(mesh, star, std::move(near), kLayers);
  return parallel_collect<Index>(mesh.T.rows(), kLightGrain,
                                 [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
                                   for (Index t = static_cast<Index>(begin); t < end; ++t)
                                     if (chosen[t]) out.push_back(t);
                                 });
}

double radius_edge(const TetMesh& mesh, Index t) {
  return std::sqrt(squared_radius_edge(mesh.V.row(mesh.T(t, 0)), mesh.V.row(mesh.T(t, 1)),
                                       mesh.V.row(mesh.T(t, 2)), mesh.V.row(mesh.T(t, 3))));
}

double worst_quality(const TetMesh& mesh) {
  count(Count::touched_tets, mesh.T.rows());
  return parallel_reduce(
      mesh.T.rows(), kLightGrain, 1.0,
      [&](std::int64_t begin, std::int64_t end) {
        double worst = 1;
        for (Index t = static_cast<Index>(begin); t < end; ++t) worst = std::min(worst, quality(mesh, t));
        return worst;
      },
      [](double x, double y) { return std::min(x, y); });
}

std::int64_t count_below(const TetMesh& mesh, double sine) {
  return parallel_reduce(
      mesh.T.rows(), kLightGrain, std::int64_t{0},
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
  count(Count::touched_tets, std::ssize(chosen));
  parallel_for(
      static_cast<std::int64_t>(chosen.size()), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin; i < end; ++i)
          weight[i] = what == Work::refine
                          ? (radius_edge(mesh, chosen[i]) > options.radius_edge ? kBadToRefineWeight : 1)
                          : (quality(mesh, chosen[i]) < target ? kBadTetWeight : 1);
      });
  return weight;
}

void add(ImproveResult& sum, const PartResult& part, std::size_t first_pass) {
  sum.end = std::max(sum.end, part.passes.end);
  sum.thinned += part.thinned;
  sum.refined += part.refined;
  sum.coarsened += part.coarsened;
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

// A mesh on its way: rounds over parts of it, then looks at what is left.
class Improver {
 public:
  Improver(TetMesh& mesh, const ImproveOptions& options, const RunContext& context)
      : mesh_(mesh),
        options_(options),
        context_(context),
        begin_(RunContext::Clock::now()),
        budget_(std::min(options.seconds, 0.5 * context.seconds_left())),
        silent_(context),
        progress_(context) {
    if (context.progress)
      silent_.progress = [this](std::string_view, double fraction, std::string_view detail) {
        progress_.within(fraction, detail);
      };
    // The mesh is to be checked and written in what time is left.
    silent_.deadline =
        std::min(context.deadline, begin_ + std::chrono::duration_cast<RunContext::Clock::duration>(
                                                std::chrono::duration<double>(budget_)));
  }

  Result<ImproveResult> run() {
    result_.before = dihedral_statistics(mesh_.V, mesh_.T);
    loose_.assign(static_cast<std::size_t>(mesh_.V.rows()), 1);
    std::fill(loose_.begin(), loose_.begin() + mesh_.surface_vertices + options_.placed, 0);

    thin_out();
    if (options_.sizes.any())
      if (Status s = begin_sizes(); !s) return s.error();
    const bool cut = parts_for(static_cast<std::size_t>(mesh_.T.rows()), options_.tets_per_part) > 1;
    if (cut && options_.radius_edge > 0) rounds(Work::refine);
    rounds(cut ? Work::passes : Work::both);
    if (sizes_)
      if (Status s = end_sizes(); !s) return s.error();
    look_at_worst(cut);
    // Lifting leaves vertices that nothing needs.
    if (result_.lifted > 0) look_at(Work::passes, sine_of(kLookAgain * options_.target_degrees));
    trade();
    // What is made smaller in the end may leave a bad angle, and mending that a large tet.
    for (int again = 0; sizes_ && again < kInVain; ++again) {
      const std::int64_t before = result_.refined;
      if (Status s = end_sizes(); !s) return s.error();
      if (result_.refined == before) break;
      look_at_worst(cut);
    }
    if (options_.coarse) coarsen_all();
    if (context_.cancel && context_.stop()) return *context_.stop();
    result_.after = dihedral_statistics(mesh_.V, mesh_.T);
    result_.seconds = since_begin();
    return std::move(result_);
  }

 private:
  double since_begin() const {
    return std::chrono::duration<double>(RunContext::Clock::now() - begin_).count();
  }

  // One round: all parts at the same time, the heaviest first. Returns the vertices that several parts
  // shared.
  std::vector<char> round(Work what, const std::vector<int>& part_of, int count,
                          std::span<const Index> chosen, std::span<const int> weight,
                          std::span<const char> fresh) {
    const std::size_t first_pass = result_.passes.size();
    std::vector<MeshPart> parts = take_parts(mesh_, part_of, count);
    std::vector<PartResult> results(parts.size());
    const double seconds = std::max(0.0, budget_ - since_begin());
    std::vector<std::pair<std::int64_t, int>> order(parts.size());
    for (int p = 0; p < count; ++p) order[p].second = p;
    for (std::size_t i = 0; i < chosen.size(); ++i) order[part_of[chosen[i]]].first -= weight[i];
    std::sort(order.begin(), order.end());
    const Orders orders{what, loose_, fresh, options_, price_, sizes_ ? &*sizes_ : nullptr, seconds};
    parallel_tasks(count, [&](std::int64_t i) {
      const int p = order[i].second;
      results[p] = improve_part(parts[p], orders, silent_);
      progress_.part_ended();
    });
    for (const PartResult& part : results) add(result_, part, first_pass);
    result_.rounds.push_back(count);
    std::vector<char> times_shared(static_cast<std::size_t>(mesh_.V.rows()), 0);
    for (const MeshPart& part : parts)
      for (const Index v : part.shared)
        if (char& times = times_shared[part.vertex[v]]; times < 2) ++times;
    const std::vector<Index> number = put_parts(mesh_, part_of, parts);
    if (sizes_) {
      std::vector<std::vector<LocalSize>> sizes;
      for (PartResult& part : results) sizes.push_back(std::move(part.sizes));
      sizes_->take(number, parts, sizes);
    }
    std::vector<char> shared(static_cast<std::size_t>(mesh_.V.rows()), 0), still_loose(shared.size(), 0);
    for (std::size_t v = 0; v < number.size(); ++v) {
      if (number[v] < 0) continue;
      shared[number[v]] = times_shared[v] > 1;
      still_loose[number[v]] = loose_[v];
    }
    loose_ = std::move(still_loose);
    return shared;
  }

  std::vector<Index> all_tets() const {
    std::vector<Index> all(static_cast<std::size_t>(mesh_.T.rows()));
    std::iota(all.begin(), all.end(), 0);
    return all;
  }

  // How the mesh is cut for the first round.
  struct Cuts {
    int count = 1;
    bool mostly_bad = false;
  };
  Cuts first_cuts(Work what, std::span<const int> weight) const {
    Cuts cuts;
    if (what == Work::refine) cuts.count = kRefineParts;
    if (what == Work::passes) {
      cuts.count = parts_for(weight.size(), options_.tets_per_part);
      const auto bad = static_cast<double>(std::count(weight.begin(), weight.end(), kBadTetWeight));
      cuts.mostly_bad = bad >= kMostlyBad * static_cast<double>(weight.size());
      if (!cuts.mostly_bad) cuts.count = std::max(kLeastParts, cuts.count);
    }
    return cuts;
  }

  // All tets, then what is unfinished around the cuts, until nothing was cut.
  void rounds(Work what) {
    std::vector<Index> chosen = all_tets();
    std::vector<int> weight = weights(mesh_, chosen, what, options_);
    std::vector<char> fresh;
    auto [count, mostly_bad] = first_cuts(what, weight);
    const double slack = count == kRefineParts ? kSlackForTwo : kSlack;
    while (!chosen.empty()) {
      const bool first = result_.rounds.size() < 3;
      progress_.begin(what == Work::refine ? 0
                      : first              ? 0.3
                                           : 0.8,
                      what == Work::refine ? 0.3
                      : first              ? 0.8
                                           : 0.95,
                      count, std::to_string(chosen.size()) + " tets in " + std::to_string(count) + " parts");
      const bool last = count == 1;
      // Nothing is cut any more, but in the passes what does not hang together is shared out.
      if (last && what == Work::passes && !fresh.empty() && !mostly_bad) count = pieces_for(chosen.size());
      Pieces pieces;
      if (!fresh.empty()) pieces = in_pieces(mesh_, chosen, count, weight);
      if (fresh.empty() || (!last && pieces.uneven > kUneven))
        pieces.part_of = cut_apart(mesh_, chosen, count, slack, weight);
      fresh = round(what, pieces.part_of, count, chosen, weight, fresh);
      if (last || silent_.stop()) return;
      const auto before = static_cast<double>(chosen.size());
      chosen = around(mesh_, unfinished(mesh_, fresh, what, options_));
      if (static_cast<double>(chosen.size()) > kShrinks * before) return;
      // Fewer, so that the cuts are not where they were before.
      count = std::min(count, parts_for(chosen.size(), kTetsAroundCuts)) / 2 + 1;
      if (what == Work::refine || count == 2) count = 1;
      weight = weights(mesh_, chosen, what, options_);
    }
  }

  // Where there are far more tets than a good mesh of this surface has: vertices go until that is over.
  void thin_out() {
    if (mesh_.T.rows() <= kOverfull * mesh_.surface_vertices) return;
    context_.report("improve", 0, "thinning out " + std::to_string(mesh_.T.rows()) + " tets");
    for (int count = parts_for(static_cast<std::size_t>(mesh_.T.rows()), options_.tets_per_part); count > 0;
         count = count > 1 ? 1 : 0) {
      const std::vector<Index> chosen = all_tets();
      const std::vector<int> weight(chosen.size(), 1);
      round(Work::thin, cut_apart(mesh_, chosen, count, kSlack, weight), count, chosen, weight, {});
      if (silent_.stop()) return;
    }
  }

  // In the end: fewer vertices, as far as the target angle allows. Where the mesh is cut, once more without
  // cuts.
  void coarsen_all() {
    for (int count = parts_for(static_cast<std::size_t>(mesh_.T.rows()), options_.tets_per_part); count > 0;
         count = count > 1 ? 1 : 0) {
      if (silent_.stop()) return;
      context_.report("improve", 0.9, "coarsening " + std::to_string(mesh_.T.rows()) + " tets");
      const std::vector<Index> chosen = all_tets();
      const std::vector<int> weight(chosen.size(), 1);
      round(Work::coarsen, cut_apart(mesh_, chosen, count, kSlack, weight), count, chosen, weight, {});
    }
  }

  Status begin_sizes() {
    sizes_.emplace(mesh_, options_.sizes);
    result_.fixed_too_long = sizes_->fixed_too_long(mesh_);
    return shrink(Work::shrink);
  }

  // What is too large still, or again (the worst places know no limits), and the passes again for what that
  // takes.
  Status end_sizes() {
    for (int again = 0; again < kInVain && !silent_.stop(); ++again) {
      result_.too_large = static_cast<std::int64_t>(sizes_->too_large(mesh_).size());
      if (result_.too_large == 0) return success();
      const std::int64_t before = result_.refined;
      if (Status s = shrink(Work::shrink_last); !s) return s;
      if (result_.refined == before) break;
      look_at(Work::passes, sine_of(options_.target_degrees));
    }
    result_.too_large = static_cast<std::int64_t>(sizes_->too_large(mesh_).size());
    return success();
  }

  // Rounds over the tets that are too large and what is around them, until none is left that can be made
  // smaller.
  Status shrink(Work how) {
    int most_parts = std::numeric_limits<int>::max();
    for (int n = 0; n < kMostRounds && !silent_.stop(); ++n) {
      const std::vector<Index> large = sizes_->too_large(mesh_);
      if (large.empty()) return success();
      // The field is known where there are vertices only: asked again as they come.
      if (const double tets = sizes_->estimate(mesh_); tets > kMostTets)
        return Error{ErrorCode::usage, "The sizes that are asked for need more than " +
                                           std::to_string(static_cast<std::int64_t>(kMostTets / 1e6)) +
                                           " million tets; ask for larger ones."};
      context_.report(
          "improve", 0.1,
          std::to_string(large.size()) + " of " + std::to_string(mesh_.T.rows()) + " tets are too large");
      std::vector<char> is_large(static_cast<std::size_t>(mesh_.T.rows()), 0);
      for (const Index t : large) is_large[t] = 1;
      const std::vector<Index> chosen =
          kMostlyBad * static_cast<double>(mesh_.T.rows()) < static_cast<double>(large.size())
              ? all_tets()
              : around(mesh_, corners_of(mesh_, [&](Index t) { return is_large[t]; }));
      const int count = std::min(most_parts, parts_for(chosen.size(), options_.tets_per_part));
      const std::vector<int> weight = sizes_->weights(mesh_, chosen);
      const std::int64_t before = result_.refined;
      round(how, cut_apart(mesh_, chosen, count, kSlack, weight), count, chosen, weight, {});
      if ((result_.refined - before) * kIdlePart > static_cast<std::int64_t>(large.size())) continue;
      // Hardly anything: what is left lies at the cuts, or nothing can be done about it.
      if (count == 1) break;
      most_parts = count / 2;
    }
    return success();
  }

  // Tets below this sine wherever they are, with all that is around them.
  void look_at(Work what, double sine) {
    const std::vector<Index> chosen =
        around(mesh_, corners_of(mesh_, [&](Index t) { return quality(mesh_, t) < sine; }));
    const int count = pieces_for(chosen.size());
    if (chosen.empty() || silent_.stop()) return;
    const std::vector<int> weight = weights(mesh_, chosen, what, options_);
    round(what, in_pieces(mesh_, chosen, count, weight).part_of, count, chosen, weight, {});
  }

  // After rounds, in which the mesh may have been cut.
  void look_at_worst(bool was_cut) {
    if (was_cut) look_at(Work::passes, sine_of(kLookAgain * options_.target_degrees));
    double worst = worst_quality(mesh_);
    const double target = sine_of(options_.target_degrees);
    for (int look = 0; look < kMostRounds && worst < target; ++look) {
      look_at(Work::look, std::min(target, kWorstOfAll * worst));
      const double before = worst;
      worst = worst_quality(mesh_);
      if (!(worst > kPays * before)) break;
    }
    if (!silent_.stop()) result_.lifted += lift_worst(mesh_, target, silent_);
    // Lifting has numbered vertices anew, and only refinement asks.
    loose_.assign(static_cast<std::size_t>(mesh_.V.rows()), 0);
    if (sizes_) sizes_->spread(mesh_, options_.sizes);
  }

  // Too many bad ones: fewer, be they worse. What is good enough for the target is good. The mesh stays as it
  // was where there would still be too many.
  void trade() {
    const double good = sine_of(std::min(options_.good_degrees, options_.target_degrees));
    const auto times_too_many = [&] {
      return static_cast<double>(count_below(mesh_, good)) /
             (kABitLess * options_.bad_share * static_cast<double>(mesh_.T.rows()));
    };
    const double too_many = times_too_many();
    if (!(too_many > 1 && too_many < kHopeless) || silent_.stop()) return;
    const TetMesh before = mesh_;
    price_.goal = kABitMore * good;
    price_.low = kMayFallTo * good;
    look_at(Work::trade, price_.goal);
    price_.low = kRaiseTo * good;
    price_.steep = kSteep;
    look_at(Work::raise, price_.goal);
    if (times_too_many() <= 1) return;
    mesh_ = before;
    loose_.assign(static_cast<std::size_t>(mesh_.V.rows()), 0);
    result_.traded = 0;
    if (sizes_) sizes_->spread(mesh_, options_.sizes);
  }

  TetMesh& mesh_;
  const ImproveOptions& options_;
  const RunContext& context_;
  const RunContext::Clock::time_point begin_;
  const double budget_;  // seconds
  RunContext silent_;    // of the parts: what they tell is theirs, the deadline this stage's
  RoundProgress progress_;
  ImproveResult result_;
  std::optional<SizeField> sizes_;  // where they are limited
  std::vector<char> loose_;         // vertices of the inside, as given
  LocalOperations::Price price_;    // where fewer tets are to be bad
};

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
  if (placed < 0) return Error{ErrorCode::usage, "The number of placed vertices must not be negative."};
  if (tets_per_part < 1) return Error{ErrorCode::usage, "A part of the mesh must have at least one tet."};
  if (!(sizes.max_volume > 0 && sizes.max_edge > 0))
    return Error{ErrorCode::usage,
                 "The largest volume and the longest edge of a tet must be positive numbers."};
  for (const double size : sizes.at_surface)
    if (!(size > 0))
      return Error{ErrorCode::usage, "The sizes at the surface's vertices must be positive numbers."};
  if (!(seconds >= 0)) return Error{ErrorCode::usage, "The time for the quality pass must not be negative."};
  return success();
}

Result<ImproveResult> improve(TetMesh& mesh, const ImproveOptions& options, const RunContext& context) {
  if (auto status = options.validate(); !status.ok()) return status.error();
  OVERTET_EXPECTS(mesh.surface_vertices + options.placed <= mesh.V.rows());
  OVERTET_EXPECTS(first_not_positive(mesh) < 0);
  if (auto error = context.stop()) return *error;
  return Improver(mesh, options, context).run();
}

}  // namespace overtet
