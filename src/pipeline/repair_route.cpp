#include "src/pipeline/repair_route.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>

#include "src/certificates/diagnose.h"
#include "src/forward_flow/forward_flow.h"
#include "src/pipeline/stage_clock.h"
#include "src/repair/least_move.h"
#include "src/repair/lessening.h"
#include "src/repair/repair.h"
#include "src/volume_map/volume_map.h"

namespace overtet {

namespace {

constexpr int kRepairs = 8;
constexpr double kFar = 0.6;         // of the diagonal: as far as it takes; the way back is still to come
constexpr double kShrinkWork = 1e4;  // of gentle repairs: the way back does the rest
constexpr double kPullTime = 0.4;    // of the time that is left, where there is a limit
constexpr double kDown = 0.995;      // three digits that are printed are never more
constexpr double kGentle = 0.01;     // moves of this size are as good as smaller ones

// Moving less, in rounds.
constexpr int kRounds = 8, kGentleRounds = 1;
constexpr int kIdle = 2, kIdleTooFar = 4;    // rounds in turn that gain nothing
constexpr double kGain = 0.97;               // what a round leaves at most, to count as one that gains
constexpr double kHopeless = 15;             // times what is allowed: eight rounds do not come that far
constexpr double kPromising = 3;             // times what is allowed: worth the rounds at once
constexpr double kNearer = 0.7;              // of the largest move is aimed at, where that is too far
constexpr double kWithin = 0.98;             // of what is allowed, where that is near
constexpr double kWorse = 1.2;               // than the best
constexpr double kTooFar = 1e30;             // what it costs to be too far
constexpr std::size_t kFew = 3, kMany = 50;  // vertices that have moved gently
constexpr int kStraightBack = 2;             // times
constexpr double kRoundsWork = 2e8;          // src/volume_map/volume_map.h; about 10 s on one thread
constexpr double kTetWork = 1000;            // a tet that is made or improved, in the same unit
constexpr double kRoundsTime = 0.5;          // of the time that is left, where there is a limit

// How far vertices may move on the way out. shrunk: far, and then less as long as nothing objects: another
// place to start the way back from. flowed: as far as the flow of src/forward_flow goes.
enum class Reach { gentle, far, shrunk, allowed, flowed };

class Repairing {
 public:
  Repairing(const RepairRoute& route, const Error& first) : route_(route), first_(first) {
    const VertexMatrix& V = route.surface.V;
    diagonal_ = (V.colwise().maxCoeff() - V.colwise().minCoeff()).norm();
  }

  Result<RepairedMesh> run(const std::optional<Eigen::Vector3d>& unglued) {
    const double least = least_relative_move();
    if (auto stop = route_.context.stop()) return *stop;
    if (least > route_.max_move)
      return with_percent(" Vertices would have to move by at least ", kDown * least, " % of the diagonal.");
    bool looked_at = false;
    std::optional<RepairedMesh> nearest;  // of those that went too far
    for (const Reach reach : {Reach::gentle, Reach::far, Reach::allowed, Reach::shrunk, Reach::flowed}) {
      if (reach == Reach::shrunk && !found_surface_) continue;  // it finds what far finds
      Result<std::optional<RepairedMesh>> away =
          reach == Reach::flowed ? flow_away() : move_away(reach, unglued);
      if (!away) return away.error();
      if (!away.value()) continue;
      found_mesh_ = true;
      RepairedMesh best = std::move(*away.value());
      Result<std::optional<RepairedMesh>> back = pull_back(best, reach);
      if (!back) return back.error();
      if (back.value() && (best.max_relative > route_.max_move || better(*back.value(), best)))
        best = std::move(*back.value());
      const bool promising = best.max_relative <= kPromising * route_.max_move;
      if (promising)
        if (Status s = move_less(best); !s) return s.error();
      if (best.max_relative <= route_.max_move) return best;
      if (!nearest || best.max_relative < nearest->max_relative) {
        nearest = std::move(best);
        looked_at = promising;
      }
    }
    if (nearest && !looked_at && nearest->max_relative <= kHopeless * route_.max_move) {
      if (Status s = move_less(*nearest); !s) return s.error();
      if (nearest->max_relative <= route_.max_move) return std::move(*nearest);
    }
    return nearest ? with_percent(" Moving vertices by up to ", nearest->max_relative + 1e-4,
                                  " % of the diagonal would do.")
                   : first_;
  }

 private:
  // What `first_` says, and how far vertices would have to move.
  Error with_percent(const char* before, double relative, const char* after) const {
    char number[32];
    std::snprintf(number, sizeof number, "%.3g", 100 * relative);
    Error error = first_;
    error.message += std::string(before) + number + after;
    return error;
  }

  // No repair moves less than that.
  double least_relative_move() const {
    const Result<Diagnosis> d = diagnose(route_.surface, {}, route_.context);
    if (!d) return 0;
    const std::optional<LeastMove> least = least_move(route_.surface, d.value(), route_.context);
    return least ? least->distance / diagonal_ : 0;
  }

  static bool is_far(Reach reach) { return reach != Reach::gentle && reach != Reach::allowed; }

  // The surroundings of what crosses are smoothed until nothing does: that has a mesh, whatever the input is,
  // as long as it does not face inwards. None: nothing is left to cross before the flow comes to a rest.
  Result<std::optional<RepairedMesh>> flow_away() {
    Result<ForwardFlowResult> flowed = timed_stage(
        "forward_flow", route_.records, route_.context,
        [&](StageRecord& record) -> Result<ForwardFlowResult> {
          std::vector<std::array<Index, 2>> pairs;
          Result<Diagnosis> d = diagnose(route_.surface, {}, route_.context);
          if (!d) return d.error();
          for (const auto& [f, g] : d.value().pairs) pairs.push_back({f, g});
          ForwardFlowOptions options;
          options.keep_states = false;
          Result<ForwardFlowResult> r = forward_flow(route_.surface, pairs, options, route_.context);
          if (r) record.iterations = static_cast<std::int64_t>(r.value().steps.size());
          return r;
        });
    if (!flowed) {
      if (auto stop = route_.context.stop()) return *stop;
      route_.context.note(LogLevel::info, "Repair: " + flowed.error().message);
      return std::optional<RepairedMesh>();
    }
    MeshAttempt attempt = route_.mesh({std::move(flowed.value().V), route_.surface.F}, false);
    if (attempt.done) return std::optional(measured(std::move(attempt.mesh)));
    if (!repairable(attempt.done.error())) return attempt.done.error();
    return std::optional<RepairedMesh>();
  }

  // None: no surface with a mesh was found.
  Result<std::optional<RepairedMesh>> move_away(Reach reach, std::optional<Eigen::Vector3d> unglued) {
    RepairOptions options;
    options.max_relative_move = is_far(reach) ? std::max(kFar, route_.max_move) : route_.max_move;
    options.only_gently = reach == Reach::gentle;
    if (reach == Reach::gentle) options.shrink_work = kShrinkWork;
    if (reach == Reach::far) options.max_shrink_rounds = 0;  // it leads the way back astray
    for (int round = 0; round < kRepairs; ++round) {
      options.place = unglued;
      Result<RepairResult> fixed = timed_stage(
          "repair", route_.records, route_.context, [&](StageRecord& record) -> Result<RepairResult> {
            Result<RepairResult> r = repair(route_.surface, options, route_.context);
            if (!r) return r;
            const RepairResult& x = r.value();
            record.iterations = static_cast<std::int64_t>(x.rounds.size());
            record.figures = {{"moved", static_cast<std::int64_t>(x.moved.size())},
                              {"max_relative", x.max_relative},
                              {"mean_relative", x.mean_relative},
                              {"turned_parts", std::int64_t{x.turned_parts}},
                              {"shrink_rounds", std::int64_t{x.shrink_rounds}},
                              {"termination", x.termination}};
            return r;
          });
      if (!fixed) {
        // Not closed, and the like: what the first look said is better. A stop is a stop.
        const ErrorCode code = fixed.error().code;
        if (code != ErrorCode::infeasible && code != ErrorCode::bad_input) return fixed.error();
        route_.context.note(LogLevel::info, "Repair: " + fixed.error().message);
        return std::optional<RepairedMesh>();
      }
      if (fixed.value().moved.empty()) return std::optional<RepairedMesh>();
      if (reach == Reach::far) found_surface_ = true;
      options.earlier = fixed.value().memory;
      MeshAttempt attempt = route_.mesh(fixed.value().surface, found_mesh_);
      if (attempt.done) return std::optional(measured(std::move(attempt.mesh)));
      if (!repairable(attempt.done.error())) return attempt.done.error();  // the time is up, and the like
      unglued = attempt.unglued;
    }
    return std::optional<RepairedMesh>();
  }

  Result<std::optional<RepairedMesh>> pull_back(const RepairedMesh& from, Reach reach) {
    return pull(from, is_far(reach),
                is_far(reach) ? route_.max_move : std::numeric_limits<double>::infinity());
  }

  // None: it cannot be pulled. slowly: measured: fewer rings and a force that grows faster cost a third and
  // end as near, but not after moves that went far.
  Result<std::optional<RepairedMesh>> pull(const RepairedMesh& from, bool slowly, double largest_move,
                                           bool spread_first = false) {
    VolumeMapOptions options;
    options.spread_first = spread_first;
    options.refinements = 0;
    if (!slowly) {
      options.interior_rings = 2;
      options.first_pull = 0.3;
      options.pull_growth = 4;
    }
    options.largest_move = largest_move * diagonal_;
    options.seconds = std::min(options.seconds, kPullTime * route_.context.seconds_left());
    Result<VolumeMapResult> pulled = timed_stage(
        "volume_map", route_.records, route_.context, [&](StageRecord& record) -> Result<VolumeMapResult> {
          Result<VolumeMapResult> r = volume_map(from.mesh, route_.surface.V, {}, options, route_.context);
          if (!r) return r;
          const VolumeMapResult& x = r.value();
          if (x.cut_by_time)
            route_.context.note(LogLevel::warning,
                                "Repair: the way back ended early because of the time limit: with more time "
                                "vertices may move less.");
          record.iterations = static_cast<std::int64_t>(x.rounds.size());
          record.figures = {{"away_at_start", std::int64_t{x.away_at_start}},
                            {"moved", static_cast<std::int64_t>(x.away.size())},
                            {"max_relative", x.farthest / diagonal_},
                            {"newton_steps", x.newton_steps},
                            {"tets", std::int64_t{x.mesh.T.rows()}}};
          return r;
        });
    if (!pulled) {
      if (auto stop = route_.context.stop()) return *stop;
      route_.context.note(LogLevel::info, "Repair: " + pulled.error().message);
      return std::optional<RepairedMesh>();
    }
    work_ += pulled.value().work;
    const bool spread_only = spread_first && pulled.value().rounds.empty();
    RepairedMesh back = measured(std::move(pulled.value().mesh));
    back.pulled = true;
    back.spread = spread_only;
    return std::optional(std::move(back));
  }

  // What a pull leaves away from its place is held by the tets around it. Among others it is free again.
  Status move_less(RepairedMesh& best) {
    const bool gentle = best.max_relative <= kGentle;
    if (gentle && best.moved.size() <= kFew) return success();
    const int rounds = !gentle ? kRounds : best.moved.size() > kMany ? kGentleRounds : 0;
    work_ = 0;
    const auto start = RunContext::Clock::now();
    const double seconds = kRoundsTime * route_.context.seconds_left();
    double longest = 0;  // round
    // Whether there is time for another round; noted where there is not.
    const auto time_left = [&] {
      const double gone = std::chrono::duration<double>(RunContext::Clock::now() - start).count();
      if (gone + 2 * longest <= seconds) return true;
      route_.context.note(LogLevel::warning,
                          "Repair: with more time than the time limit leaves, vertices may move less.");
      return false;
    };
    int round = 0;
    for (int time = 0; time < kStraightBack; ++time) {
      RepairedMesh now = best;
      bool as_made = false;  // what the last round went on from
      for (int idle = 0; round < rounds && work_ < kRoundsWork; ++round) {
        const bool too_far = best.max_relative > route_.max_move;
        if (idle >= (too_far ? kIdleTooFar : kIdle)) break;
        if (!now.pulled && as_made && idle % 2 == 1) {  // there are no other tets of it: the same again
          ++idle;
          continue;
        }
        as_made = !now.pulled;
        if (!time_left()) return success();
        const auto begin = RunContext::Clock::now();
        Result<std::optional<RepairedMesh>> back = pulled_again(now, best, idle);
        if (!back) return back.error();
        longest = std::max(longest, std::chrono::duration<double>(RunContext::Clock::now() - begin).count());
        const double before = cost(best);
        if (back.value() && cost(*back.value()) < before) best = *back.value();
        idle = cost(best) > kGain * before ? idle + 1 : 0;
        // A little worse is another way to go on while everything is too far.
        const bool on = back.value() && too_far && cost(*back.value()) < kWorse * cost(best);
        now = on ? std::move(*back.value()) : best;
      }
      if (!time_left()) return success();
      const double before = cost(best);
      const bool last = round >= rounds || work_ >= kRoundsWork || !best.pulled;  // pulling does not help it
      if (Status s = straight_back(best, last ? kStraightBack - time : 1); !s) return s;
      if (last || cost(best) > kGain * before) break;
    }
    return success();
  }

  // One round: other tets, and another pull. As long as vertices are further away than allowed, the farthest
  // are brought nearer at the cost of others; after that as many as can be come home. The same again would
  // come to the same, so after rounds without gain there are other tets again, and then slower pulls.
  Result<std::optional<RepairedMesh>> pulled_again(const RepairedMesh& from, const RepairedMesh& best,
                                                   int idle) {
    Result<std::optional<RepairedMesh>> fresh = refreshed(from, idle % 2 == 1);
    if (!fresh) return fresh.error();
    if (!fresh.value()) return std::optional<RepairedMesh>();
    const double allowed = route_.max_move, most = best.max_relative;
    const double aim = most > allowed ? std::max(kNearer * most, kWithin * allowed) : allowed;
    Result<std::optional<RepairedMesh>> nearer = pull(*fresh.value(), idle >= 2, aim, most > allowed);
    if (!nearer || !from.spread) return nearer;
    // What was only brought nearer has not tried to go home from there yet.
    Result<std::optional<RepairedMesh>> home = pull(*fresh.value(), idle >= 2, most);
    if (!home) return home;
    return home.value() && (!nearer.value() || cost(*home.value()) < cost(*nearer.value())) ? home : nearer;
  }

  // What the diagnosis alone lets go home, straight, so many times; where that has a mesh.
  Status straight_back(RepairedMesh& best, int times) {
    std::vector<RepairedMesh> nearer;  // surfaces
    for (int time = 0; time < times; ++time) {
      const RepairedMesh& from = nearer.empty() ? best : nearer.back();
      RunContext context = route_.context;
      if (context.deadline != RunContext::Clock::time_point::max())
        context.deadline =
            RunContext::Clock::now() + std::chrono::duration_cast<RunContext::Clock::duration>(
                                           std::chrono::duration<double>(kPullTime * context.seconds_left()));
      Result<LessenResult> less = timed_stage(
          "lessen", route_.records, route_.context, [&](StageRecord& record) -> Result<LessenResult> {
            Result<LessenResult> r = lessen(route_.surface, from.surface.V, {}, context);
            if (!r) return r;
            record.iterations = r.value().looks;
            if (r.value().cut_by_time)
              route_.context.note(
                  LogLevel::warning,
                  "Repair: with more time than the time limit leaves, vertices may move less.");
            return r;
          });
      if (!less) return less.error();
      if (!less.value().lessened) break;
      RepairedMesh to = moves_to(less.value().V);
      const bool worthwhile = cost(to) <= kGain * cost(from);
      nearer.push_back(std::move(to));
      if (!worthwhile) break;
    }
    // The nearest is meshed; those before it only where it has no mesh.
    for (auto surface = nearer.rbegin(); surface != nearer.rend(); ++surface) {
      if (!(cost(*surface) < cost(best))) continue;
      MeshAttempt attempt = route_.mesh(surface->surface, true);
      if (attempt.done) {
        best = measured(std::move(attempt.mesh));
        return success();
      }
      if (!repairable(attempt.done.error())) return attempt.done;
    }
    return success();
  }

  // The surface with other tets.
  Result<std::optional<RepairedMesh>> refreshed(const RepairedMesh& mesh, bool anew) {
    if (!mesh.pulled) return std::optional(mesh);
    MeshAttempt attempt;
    if (anew) {
      attempt = route_.mesh(mesh.surface, true);
      if (!attempt.done && !repairable(attempt.done.error())) return attempt.done.error();
    }
    if (!anew || !attempt.done) {
      attempt = route_.improve(mesh.surface, mesh.mesh);
      if (!attempt.done && !repairable(attempt.done.error())) return attempt.done.error();
    }
    if (!attempt.done) return std::optional<RepairedMesh>();
    work_ += kTetWork * static_cast<double>(attempt.mesh.T.rows());
    return std::optional(measured(std::move(attempt.mesh)));
  }

  // Few vertices, and small moves, count alike; nothing counts as much as a move that is too large.
  double cost(const RepairedMesh& r) const {
    if (r.max_relative > route_.max_move) return kTooFar * r.max_relative;
    const auto n = static_cast<double>(r.moved.size());
    return n * n * r.max_relative * r.mean_relative;
  }

  RepairedMesh measured(TetMesh mesh) const {
    RepairedMesh r = moves_to(mesh.V.topRows(route_.surface.V.rows()));
    r.mesh = std::move(mesh);
    return r;
  }

  // Without a mesh.
  RepairedMesh moves_to(const VertexMatrix& moved) const {
    RepairedMesh r;
    const VertexMatrix& V = route_.surface.V;
    r.surface = {moved, route_.surface.F};
    for (Index v = 0; v < V.rows(); ++v) {
      if (r.surface.V.row(v) == V.row(v)) continue;
      const double move = (r.surface.V.row(v) - V.row(v)).norm() / diagonal_;
      r.moved.push_back(v);
      r.max_relative = std::max(r.max_relative, move);
      r.mean_relative += move;
    }
    if (!r.moved.empty()) r.mean_relative /= static_cast<double>(r.moved.size());
    return r;
  }

  // Fewer vertices, less far altogether, and none much further.
  static bool better(const RepairedMesh& a, const RepairedMesh& b) {
    const auto total = [](const RepairedMesh& r) {
      return static_cast<double>(r.moved.size()) * r.mean_relative;
    };
    return a.moved.size() <= b.moved.size() && total(a) < total(b) &&
           a.max_relative <= std::max(b.max_relative, kGentle);
  }

  const RepairRoute& route_;
  const Error& first_;
  double diagonal_ = 0;
  bool found_surface_ = false;  // to which nothing objects, far away
  bool found_mesh_ = false;     // of a surface that went too far: others are tried, but not at any price
  double work_ = 0;             // of the rounds of moving less
};

}  // namespace

Result<RepairedMesh> mesh_repaired(const RepairRoute& route, const Error& first,
                                   std::optional<Eigen::Vector3d> unglued) {
  return Repairing(route, first).run(unglued);
}

bool repairable(const Error& e) {
  return e.code == ErrorCode::infeasible || e.code == ErrorCode::unsolved || e.code == ErrorCode::bad_input;
}

}  // namespace overtet
