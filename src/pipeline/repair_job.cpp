#include "src/pipeline/repair_job.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "src/cdt/tuning.h"
#include "src/pipeline/finishing.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/surface_run.h"
#include "src/pipeline/tuning.h"
#include "src/repair/repair.h"
#include "src/volume_map/volume_map.h"

namespace overtet {

namespace {

// What is pulled back to the input locks early where it is made of bad tets. Always the same, so that the
// repaired surface does not depend on what becomes of the mesh afterwards.
MeshingOptions options_of_attempts(const RepairJob& job) {
  MeshingOptions options = job.options;
  options.improve_degrees = kAttemptDegrees;
  options.sizes = {};
  options.resume.clear();  // its states are the input's
  return options;
}

}  // namespace

RepairedMesh moved_to(const RepairJob& job, const VertexMatrix& moved) {
  RepairedMesh r;
  const VertexMatrix& V = job.surface.V;
  r.surface = {moved, job.surface.F};
  Moves& moves = r.moves;
  for (Index v = 0; v < V.rows(); ++v) {
    if (r.surface.V.row(v) == V.row(v)) continue;
    const double move = (r.surface.V.row(v) - V.row(v)).norm() / job.diagonal;
    moves.vertices.push_back(v);
    moves.max_relative = std::max(moves.max_relative, move);
    moves.mean_relative += move;
  }
  if (!moves.vertices.empty()) moves.mean_relative /= static_cast<double>(moves.vertices.size());
  return r;
}

RepairedMesh measured(const RepairJob& job, TetMesh mesh) {
  RepairedMesh r = moved_to(job, mesh.V.topRows(job.surface.V.rows()));
  r.mesh = std::move(mesh);
  return r;
}

double cost(const RepairJob& job, const Moves& moves) {
  // To be too far costs more than anything else.
  if (moves.max_relative > job.allowed()) return std::numeric_limits<float>::max() * moves.max_relative;
  const auto n = static_cast<double>(moves.vertices.size());
  return n * n * moves.max_relative * moves.mean_relative;
}

bool better(const Moves& a, const Moves& b) {
  const auto total = [](const Moves& m) { return static_cast<double>(m.vertices.size()) * m.mean_relative; };
  return a.vertices.size() <= b.vertices.size() && total(a) < total(b) &&
         a.max_relative <= std::max(b.max_relative, RepairOptions().gentle_relative_move);
}

bool repairable(const Error& e) {
  return e.code == ErrorCode::infeasible || e.code == ErrorCode::unsolved || e.code == ErrorCode::bad_input;
}

MeshAttempt mesh_moved(const RepairJob& job, const Surface& moved, Need need, Tets tets) {
  MeshingOptions options = options_of_attempts(job);
  if (tets == Tets::as_made) options.improve_degrees = 0;
  SurfaceRun run(moved, {SurfaceRunSetup::Origin::repaired, need == Need::luxury ? kShortPatience : 1.0},
                 options, job.context, job.records);
  Result<TetMesh> mesh = run.go();
  return {std::move(mesh), run.unglued()};
}

Result<TetMesh> finish_moved(const RepairJob& job, const Surface& moved, TetMesh mesh) {
  return finish_given({moved, options_of_attempts(job).improve_degrees, job.context, job.records},
                      std::move(mesh));
}

Result<double> opened(const RepairJob& job, RepairedMesh& repaired, OpeningOptions::Moves moves) {
  OpeningOptions options;
  options.moves = moves;
  options.largest_move = job.allowed() * job.diagonal;
  TetMesh mesh = repaired.mesh;
  bool any = false;
  double degrees = 0;
  const Status done = timed_stage("opening", job.records, job.context, [&](StageRecord& record) -> Status {
    Result<OpeningResult> r = open_up(mesh, job.surface.V, options, job.context);
    if (!r) return r.error();
    const OpeningResult& x = r.value();
    double farthest = 0;
    std::int64_t opened = 0;
    for (const OpenedPlace& place : x.places) {
      opened += place.opened ? 1 : 0;
      record.iterations += place.rounds;
      farthest = std::max(farthest, place.farthest);
    }
    any = opened > 0;
    degrees = x.degrees_after;
    record.figures = {{"places", static_cast<std::int64_t>(x.places.size())},
                      {"opened", opened},
                      {"degrees_before", x.degrees_before},
                      {"degrees_after", x.degrees_after},
                      {"max_relative", farthest / job.diagonal},
                      {"tets", std::int64_t{mesh.T.rows()}}};
    return success();
  });
  if (!done) return done.error();
  if (!any) return degrees;
  repaired = measured(job, std::move(mesh));
  repaired.state = RepairedMesh::State::pulled;
  return degrees;
}

Result<std::optional<RepairedMesh>> pulled(const RepairJob& job, const RepairedMesh& from, const Pull& pull) {
  VolumeMapOptions options;
  options.spread_first = pull.aim == Pull::Aim::nearer;
  options.refinements = 0;
  if (pull.pace == Pull::Pace::quick) {
    options.interior_rings = 2;
    options.first_pull = 0.3;
    options.pull_growth = 4;
  }
  options.largest_move = pull.largest_move * job.diagonal;
  options.seconds = std::min(options.seconds, kHalfTime * job.context.seconds_left());
  Result<VolumeMapResult> map = timed_stage(
      "volume_map", job.records, job.context, [&](StageRecord& record) -> Result<VolumeMapResult> {
        Result<VolumeMapResult> r = volume_map(from.mesh, job.surface.V, {}, options, job.context);
        if (!r) return r;
        const VolumeMapResult& x = r.value();
        if (x.cut_by_time)
          job.context.note(LogLevel::warning,
                           "Repair: moving vertices back ended early because of the time limit; with more "
                           "time they may move less.");
        record.iterations = static_cast<std::int64_t>(x.rounds.size());
        record.figures = {{"away_at_start", std::int64_t{x.away_at_start}},
                          {"moved", static_cast<std::int64_t>(x.away.size())},
                          {"max_relative", x.farthest / job.diagonal},
                          {"newton_steps", x.newton_steps},
                          {"tets", std::int64_t{x.mesh.T.rows()}}};
        return r;
      });
  if (!map) {
    if (auto stop = job.context.stop()) return *stop;
    job.context.note(LogLevel::info, "Repair: " + map.error().message);
    return std::optional<RepairedMesh>();
  }
  const bool only_nearer = options.spread_first && map.value().rounds.empty();
  const double work = map.value().work;
  RepairedMesh back = measured(job, std::move(map.value().mesh));
  back.state = only_nearer ? RepairedMesh::State::brought_nearer : RepairedMesh::State::pulled;
  back.work = work;
  return std::optional(std::move(back));
}

}  // namespace overtet
