#include "src/pipeline/repairing.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <utility>

#include "src/pipeline/stage_clock.h"
#include "src/repair/repair.h"
#include "src/volume_map/volume_map.h"

namespace overtet {

namespace {

constexpr int kRepairs = 8;
constexpr double kFar = 0.6;         // of the diagonal: as far as it takes; the way back is still to come
constexpr double kShrinkWork = 1e4;  // of gentle repairs: the way back does the rest
constexpr double kPullTime = 0.4;    // of the time that is left, where there is a limit
constexpr double kGentle = 0.01;     // moves of this size are as good as smaller ones

// How far vertices may move on the way out.
enum class Reach { gentle, far, allowed };

class Repairing {
 public:
  Repairing(const RepairRoute& route, const Error& first) : route_(route), first_(first) {
    const VertexMatrix& V = route.surface.V;
    diagonal_ = (V.colwise().maxCoeff() - V.colwise().minCoeff()).norm();
  }

  Result<RepairedMesh> run(const std::optional<Eigen::Vector3d>& unglued) {
    double least = std::numeric_limits<double>::infinity();
    for (const Reach reach : {Reach::gentle, Reach::far, Reach::allowed}) {
      Result<std::optional<RepairedMesh>> away = move_away(reach, unglued);
      if (!away) return away.error();
      if (!away.value()) continue;
      RepairedMesh best = std::move(*away.value());
      Result<std::optional<RepairedMesh>> back = pull_back(best, reach);
      if (!back) return back.error();
      if (back.value() && (best.max_relative > route_.max_move || better(*back.value(), best)))
        best = std::move(*back.value());
      if (best.max_relative <= route_.max_move) return best;
      least = std::min(least, best.max_relative);
    }
    Error error = first_;
    if (least < 1) {
      char more[96];
      std::snprintf(more, sizeof more, " Moving vertices by up to %.3g %% of the diagonal would do.",
                    100 * least + 0.01);
      error.message += more;
    }
    return error;
  }

 private:
  // None: no surface with a mesh was found.
  Result<std::optional<RepairedMesh>> move_away(Reach reach, std::optional<Eigen::Vector3d> unglued) {
    RepairOptions options;
    options.max_relative_move = reach == Reach::far ? std::max(kFar, route_.max_move) : route_.max_move;
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
        route_.context.note(LogLevel::warning, "Repair: " + fixed.error().message);
        return std::optional<RepairedMesh>();
      }
      if (fixed.value().moved.empty()) return std::optional<RepairedMesh>();
      options.earlier = fixed.value().memory;
      MeshAttempt attempt = route_.mesh(fixed.value().surface);
      if (attempt.done) return std::optional(measured(std::move(attempt.mesh)));
      if (!repairable(attempt.done.error())) return attempt.done.error();  // the time is up, and the like
      unglued = attempt.unglued;
    }
    return std::optional<RepairedMesh>();
  }

  // None: it cannot be pulled.
  Result<std::optional<RepairedMesh>> pull_back(const RepairedMesh& from, Reach reach) {
    VolumeMapOptions options;
    options.refinements = 0;
    // Measured: fewer rings and a force that grows faster cost a third and end as near, but not after
    // moves that went far.
    if (reach != Reach::far) {
      options.interior_rings = 2;
      options.first_pull = 0.3;
      options.pull_growth = 4;
    }
    options.seconds = std::min(options.seconds, kPullTime * route_.context.seconds_left());
    options.largest_move =
        reach == Reach::far ? route_.max_move * diagonal_ : std::numeric_limits<double>::infinity();
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
    RepairedMesh back = measured(std::move(pulled.value().mesh));
    back.pulled = true;
    return std::optional(std::move(back));
  }

  RepairedMesh measured(TetMesh mesh) const {
    RepairedMesh r;
    const VertexMatrix& V = route_.surface.V;
    r.surface = {mesh.V.topRows(V.rows()), route_.surface.F};
    for (Index v = 0; v < V.rows(); ++v) {
      if (r.surface.V.row(v) == V.row(v)) continue;
      const double move = (r.surface.V.row(v) - V.row(v)).norm() / diagonal_;
      r.moved.push_back(v);
      r.max_relative = std::max(r.max_relative, move);
      r.mean_relative += move;
    }
    if (!r.moved.empty()) r.mean_relative /= static_cast<double>(r.moved.size());
    r.mesh = std::move(mesh);
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
