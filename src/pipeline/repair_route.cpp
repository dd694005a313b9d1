#include "src/pipeline/repair_route.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "kernels/bvh/self_intersections.h"
#include "src/certificates/diagnose.h"
#include "src/forward_flow/forward_flow.h"
#include "src/pipeline/moving_less.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/tuning.h"
#include "src/repair/least_move.h"
#include "src/repair/repair.h"

namespace overtet {

namespace {

// A way from the input to a surface that has a mesh.
struct WayOut {
  enum class Means {
    smoothing,  // src/repair
    flow        // src/forward_flow: the surroundings of what crosses are smoothed until nothing does
  };
  enum class Reach {
    allowed,  // no vertex goes further than it may in the end
    far       // as far as it takes: the way back is still to come
  };
  enum class Shrink {
    none,  // what is near enough goes home in its mesh; what is not, it leads astray on the way back
    full   // as long as nothing objects: another place to start the way back from
  };
  Means means = Means::smoothing;
  Reach reach = Reach::allowed;
  Shrink shrink = Shrink::none;
  bool gently = false;           // RepairOptions::only_gently
  bool only_if_far_did = false;  // finds a surface only where the way that goes far without shrinking does
};

// The way of the flow ends at a mesh, whatever the input is, as long as it does not face inwards.
const std::array ways_out = {
    WayOut{.gently = true},
    WayOut{},
    WayOut{.reach = WayOut::Reach::far},
    WayOut{.reach = WayOut::Reach::far, .shrink = WayOut::Shrink::full, .only_if_far_did = true},
    WayOut{.means = WayOut::Means::flow, .reach = WayOut::Reach::far},
};

RepairOptions options_of(const RepairJob& job, const WayOut& way) {
  const double allowed = job.allowed();
  RepairOptions options;
  options.max_relative_move = way.reach == WayOut::Reach::far ? std::max(kFar, allowed) : allowed;
  options.only_gently = way.gently;
  options.diagnosis = &job.diagnosis;
  if (way.shrink == WayOut::Shrink::none) options.max_shrink_rounds = 0;
  return options;
}

class Repairing {
 public:
  Repairing(const RepairJob& job, const Error& first, const std::optional<Eigen::Vector3d>& unglued)
      : job_(job), first_(first), unglued_(unglued) {}

  Result<RepairedMesh> run() {
    const double least = least_relative_move();
    if (auto stop = job_.context.stop()) return *stop;
    if (least > job_.allowed())
      // Three digits that are printed are never more than it.
      return with_percent(" To repair the surface, some vertex would have to move by at least ",
                          0.995 * least, " % of the diagonal.");
    bool moved_less = false;              // the nearest
    std::optional<RepairedMesh> nearest;  // of those that went too far
    for (const WayOut& way : ways_out) {
      if (way.only_if_far_did && !found_surface_) continue;
      Result<std::optional<RepairedMesh>> there_and_back = try_way(way);
      if (!there_and_back) return there_and_back.error();
      if (!there_and_back.value()) continue;
      RepairedMesh best = std::move(*there_and_back.value());
      // What is near enough gets room after this, and goes further: no smaller moves are looked for.
      if (best.moves.max_relative <= job_.allowed()) return best;
      const bool promising = best.moves.max_relative <= kPromising * job_.allowed();
      if (promising) {
        if (Status s = move_less(job_, best); !s) return s.error();
        if (best.moves.max_relative <= job_.allowed()) return best;
      }
      if (!nearest || best.moves.max_relative < nearest->moves.max_relative) {
        nearest = std::move(best);
        moved_less = promising;
      }
    }
    if (!nearest) {
      Error error = first_;
      error.message += " The repair found no surface nearby that has a mesh.";
      return error;
    }
    if (!moved_less && nearest->moves.max_relative <= kOutOfReach * job_.allowed()) {
      if (Status s = move_less(job_, *nearest); !s) return s.error();
      if (nearest->moves.max_relative <= job_.allowed()) return std::move(*nearest);
    }
    return with_percent(" A repair exists that moves vertices by up to ", nearest->moves.max_relative + 1e-4,
                        " % of the diagonal; allow that much.");
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
    double distance = 0;
    (void)timed_stage("least_move", job_.records, job_.context, [&](StageRecord&) -> Status {
      if (const auto least = least_move(job_.surface, job_.diagnosis, job_.context))
        distance = least->distance;
      return success();
    });
    return distance / job_.diagonal;
  }

  // Out, and back as far as that makes things better. None: no surface with a mesh was found.
  Result<std::optional<RepairedMesh>> try_way(const WayOut& way) {
    Result<std::optional<RepairedMesh>> away =
        way.means == WayOut::Means::flow ? flow_away() : move_away(way);
    if (!away || !away.value()) return away;
    found_mesh_ = true;
    RepairedMesh best = std::move(*away.value());
    Pull pull;
    if (way.reach == WayOut::Reach::far) pull = {Pull::Pace::slow, job_.allowed(), Pull::Aim::home};
    Result<std::optional<RepairedMesh>> back = pulled(job_, best, pull);
    if (!back) return back;
    if (back.value() &&
        (best.moves.max_relative > job_.allowed() || better(back.value()->moves, best.moves))) {
      auto before = std::make_shared<RepairedMesh>(std::move(best));
      best = std::move(*back.value());
      if (before->moves.max_relative <= job_.allowed()) best.before_pull = std::move(before);
    }
    return std::optional(std::move(best));
  }

  // None: the flow came to a rest while something still crossed.
  Result<std::optional<RepairedMesh>> flow_away() {
    Result<ForwardFlowResult> flowed = timed_stage(
        "forward_flow", job_.records, job_.context, [&](StageRecord& record) -> Result<ForwardFlowResult> {
          std::vector<std::array<Index, 2>> pairs;
          // All of them; a diagnosis ends before where a face has no area.
          for (const auto& [f, g] : find_self_intersections(job_.surface.V, job_.surface.F))
            pairs.push_back({f, g});
          ForwardFlowOptions options;
          options.keep_states = false;
          Result<ForwardFlowResult> r = forward_flow(job_.surface, pairs, options, job_.context);
          if (r) record.iterations = static_cast<std::int64_t>(r.value().steps.size());
          return r;
        });
    if (!flowed) {
      if (auto stop = job_.context.stop()) return *stop;
      job_.context.note(LogLevel::info, "Repair: " + flowed.error().message);
      return std::optional<RepairedMesh>();
    }
    return found(mesh_moved(job_, {std::move(flowed.value().V), job_.surface.F}, Need::first));
  }

  // None: there is no mesh. Errors: the time is up, and the like.
  Result<std::optional<RepairedMesh>> found(MeshAttempt attempt) const {
    if (attempt.mesh) return std::optional(measured(job_, std::move(attempt.mesh).value()));
    if (!repairable(attempt.mesh.error())) return attempt.mesh.error();
    return std::optional<RepairedMesh>();
  }

  Result<RepairResult> smoothed(const RepairOptions& options) const {
    return timed_stage("repair", job_.records, job_.context,
                       [&](StageRecord& record) -> Result<RepairResult> {
                         Result<RepairResult> r = repair(job_.surface, options, job_.context);
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
  }

  Result<std::optional<RepairedMesh>> move_away(const WayOut& way) {
    RepairOptions options = options_of(job_, way);
    options.place = unglued_;
    const Tets tets = way.reach == WayOut::Reach::far ? Tets::improved : Tets::as_made;
    for (int round = 0; round < kRounds; ++round) {
      Result<RepairResult> fixed = smoothed(options);
      if (!fixed) {
        // Not closed, and the like: what the first look said is better. A stop is a stop.
        const ErrorCode code = fixed.error().code;
        if (code != ErrorCode::infeasible && code != ErrorCode::bad_input) return fixed.error();
        job_.context.note(LogLevel::info, "Repair: " + fixed.error().message);
        return std::optional<RepairedMesh>();
      }
      if (fixed.value().moved.empty()) return std::optional<RepairedMesh>();
      if (way.reach == WayOut::Reach::far) found_surface_ = true;
      options.earlier = fixed.value().memory;
      MeshAttempt attempt =
          mesh_moved(job_, fixed.value().surface, found_mesh_ ? Need::luxury : Need::first, tets);
      options.place = attempt.unglued;
      Result<std::optional<RepairedMesh>> mesh = found(std::move(attempt));
      if (mesh && mesh.value() && tets == Tets::as_made) mesh.value()->state = RepairedMesh::State::as_made;
      if (!mesh || mesh.value()) return mesh;
    }
    return std::optional<RepairedMesh>();
  }

  const RepairJob& job_;
  const Error& first_;
  const std::optional<Eigen::Vector3d> unglued_;
  bool found_surface_ = false;  // to which nothing objects, far away
  bool found_mesh_ = false;     // of a surface that went too far: others are tried, but not at any price
};

}  // namespace

Result<RepairedMesh> mesh_repaired(const RepairJob& job, const Error& first,
                                   std::optional<Eigen::Vector3d> unglued) {
  return Repairing(job, first, unglued).run();
}

}  // namespace overtet
