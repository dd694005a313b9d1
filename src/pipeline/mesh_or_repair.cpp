#include "src/pipeline/mesh_or_repair.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "src/pipeline/component_meshing.h"
#include "src/pipeline/finishing.h"
#include "src/pipeline/repair_route.h"
#include "src/pipeline/surface_run.h"
#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

double diagonal_of(const Surface& surface) {
  return (surface.V.colwise().maxCoeff() - surface.V.colwise().minCoeff()).norm();
}

// Why a surface has no mesh as it is, and what repairs need to know of it.
struct FirstFailure {
  Error error;
  std::optional<Eigen::Vector3d> unglued;
  std::vector<SubSurface> parts;
  Diagnosis diagnosis;
};

// The mesh of the surface as it is, or nothing and why.
Result<std::optional<TetMesh>> mesh_as_it_is(const Surface& surface, const MeshingOptions& options,
                                             const RunContext& context, Report& report,
                                             FirstFailure& failure) {
  SurfaceRunSetup setup;
  if (options.on_infeasible == OnInfeasible::repair) setup.depth = InspectionDepth::repair;
  SurfaceRun run(surface, setup, options, context, report.stages);
  report.input = run.input_record();  // also for who gives up during the diagnosis
  const Status usable = run.diagnose();
  report.input = run.input_record();
  report.certificate = run.certificate();
  Result<TetMesh> mesh = usable ? run.mesh() : Result<TetMesh>(usable.error());
  report.certificate = run.certificate();
  if (mesh) return std::optional(std::move(mesh).value());
  if (options.on_infeasible != OnInfeasible::repair || !repairable(mesh.error())) return mesh.error();
  failure = {mesh.error(), run.unglued(), run.parts(), run.diagnosis()};
  return std::optional<TetMesh>();
}

// Moves of the parts, put together to those of the whole.
class MovesOfParts {
 public:
  // size: the part's diagonal over that of the whole.
  void add(const SubSurface& part, const Moves& moves, double size) {
    for (const Index v : moves.vertices) all_.vertices.push_back(part.vertices[v]);
    all_.max_relative = std::max(all_.max_relative, size * moves.max_relative);
    sum_ += size * moves.mean_relative * static_cast<double>(moves.vertices.size());
  }
  Moves all() {
    std::sort(all_.vertices.begin(), all_.vertices.end());
    all_.mean_relative = all_.vertices.empty() ? 0 : sum_ / static_cast<double>(all_.vertices.size());
    return std::move(all_);
  }

 private:
  Moves all_;
  double sum_ = 0;
};

// The records of parts that needed no repair: what counts is how long they took altogether.
class OtherParts {
 public:
  void add(const std::vector<StageRecord>& stages) {
    ++parts_;
    for (const StageRecord& stage : stages) {
      auto sum = std::find_if(sums_.begin(), sums_.end(),
                              [&](const StageRecord& s) { return s.name == stage.name; });
      if (sum == sums_.end()) sum = sums_.insert(sums_.end(), StageRecord{stage.name, 0, 0, 0, {}});
      sum->seconds += stage.seconds;
      sum->cpu_seconds += stage.cpu_seconds;
      sum->iterations += stage.iterations;
    }
  }
  void append_to(std::vector<StageRecord>& records) {
    for (StageRecord& sum : sums_) {
      sum.figures.emplace_back("parts", parts_);
      records.push_back(std::move(sum));
    }
  }

 private:
  std::vector<StageRecord> sums_;
  std::int64_t parts_ = 0;
};

// Each part by itself, repaired where it has no mesh. Nothing is said of how they lie to each other, so none
// is moved because of another one. Errors: of the first part that could not be repaired.
Result<MeshedSurface> repair_by_parts(const Surface& surface, const std::vector<SubSurface>& parts,
                                      const MeshingOptions& options, const RunContext& context,
                                      std::vector<StageRecord>& records) {
  const double diagonal = diagonal_of(surface);
  MeshingOptions own = options;
  own.save_stages.clear();
  own.resume.clear();
  Surface repaired = surface;
  std::vector<PartMesh> meshes;
  MovesOfParts moves;
  OtherParts others;
  for (const SubSurface& part : parts) {
    const double size = diagonal_of(part.surface) / diagonal;
    own.max_repair_move = std::min(1.0, options.max_repair_move / size);
    Report report;
    Result<MeshedSurface> r = mesh_or_repair(part.surface, own, context, report);
    if (r && !r.value().moves)
      others.add(report.stages);
    else
      std::move(report.stages.begin(), report.stages.end(), std::back_inserter(records));
    if (!r) others.append_to(records);
    if (!r) return r;
    if (r.value().moves) moves.add(part, *r.value().moves, size);
    TetMesh& mesh = r.value().mesh;
    for (std::size_t v = 0; v < part.vertices.size(); ++v)
      repaired.V.row(part.vertices[v]) = mesh.V.row(static_cast<Eigen::Index>(v));
    meshes.push_back({part.vertices, std::move(mesh)});
  }
  others.append_to(records);
  // Each has been improved.
  const FinishingJob job{.input = repaired, .improve_degrees = 0, .context = context, .records = records};
  Result<TetMesh> whole = finish_given(job, united(repaired.V, meshes));
  if (!whole) return whole.error();
  return MeshedSurface{std::move(whole).value(), moves.all()};
}

// Moved vertices with as much room as can be found. Which surface it ends with does not depend on the quality
// pass that the run is to make.
Status opened_wide(const RepairJob& job, RepairedMesh& r) {
  // What was pulled has moved less; where it has no room, what it was pulled from may have.
  const std::shared_ptr<RepairedMesh> before = std::move(r.before_pull);
  const Result<double> first = opened(job, r);
  if (!first) return first.error();
  double degrees = first.value();
  if (before && degrees < OpeningOptions().usable_degrees) {
    const Result<double> others = opened(job, *before);
    if (!others) return others.error();
    if (others.value() > degrees) r = std::move(*before), degrees = others.value();
  }
  if (degrees >= OpeningOptions().usable_degrees) return success();
  // Among better tets there may be room.
  Result<TetMesh> better = finish_moved(job, r.surface, r.mesh);
  if (!better) return repairable(better.error()) ? success() : Status(better.error());
  RepairedMesh again = measured(job, std::move(better).value());
  const Result<double> second = opened(job, again);
  if (!second) return second.error();
  if (second.value() > degrees) {
    r = std::move(again);
    r.state = RepairedMesh::State::pulled;
  }
  return success();
}

// The quality pass gives up some tets for others: not those at moved vertices.
Result<TetMesh> with_room_at_moved(const RepairJob& job, RepairedMesh finished) {
  if (least_angle_at_moved(finished.mesh, job.surface.V) >= OpeningOptions().usable_degrees)
    return std::move(finished.mesh);
  RepairedMesh better = finished;
  if (const Result<double> done = opened(job, better, OpeningOptions::Moves::inside); !done)
    return done.error();
  if (better.state == RepairedMesh::State::finished) return std::move(finished.mesh);
  Result<TetMesh> checked =
      finish_given({better.surface, 0, job.context, job.records}, std::move(better.mesh));
  if (!checked && repairable(checked.error())) return std::move(finished.mesh);
  return checked;
}

Result<MeshedSurface> repair_whole(const Surface& surface, const MeshingOptions& options,
                                   const RunContext& context, std::vector<StageRecord>& records,
                                   const FirstFailure& first) {
  const RepairJob job{surface, first.diagnosis, options, context, records, diagonal_of(surface)};
  Result<RepairedMesh> repaired = mesh_repaired(job, first.error, first.unglued);
  if (!repaired) return repaired.error();
  RepairedMesh& r = repaired.value();
  if (Status s = opened_wide(job, r); !s) return s.error();
  const bool good_already =
      r.state == RepairedMesh::State::finished && options.improve_degrees <= kAttemptDegrees;
  Result<TetMesh> mesh = finish_given(
      {r.surface, good_already ? 0 : options.improve_degrees, context, records}, std::move(r.mesh));
  if (!mesh) return mesh.error();
  Result<TetMesh> settled = with_room_at_moved(job, measured(job, std::move(mesh).value()));
  if (!settled) return settled.error();
  return MeshedSurface{std::move(settled).value(), std::move(r.moves)};
}

}  // namespace

Result<MeshedSurface> mesh_or_repair(const Surface& surface, const MeshingOptions& options,
                                     const RunContext& context, Report& report) {
  FirstFailure first;
  Result<std::optional<TetMesh>> mesh = mesh_as_it_is(surface, options, context, report, first);
  if (!mesh) return mesh.error();
  if (mesh.value()) return MeshedSurface{std::move(*mesh.value()), std::nullopt};
  if (!first.parts.empty()) {
    Result<MeshedSurface> parts = repair_by_parts(surface, first.parts, options, context, report.stages);
    if (parts || !repairable(parts.error())) return parts;
    context.note(LogLevel::info,
                 "Repair: the parts could not be repaired one by one: " + parts.error().message);
  }
  return repair_whole(surface, options, context, report.stages, first);
}

}  // namespace overtet
