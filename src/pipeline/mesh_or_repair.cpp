#include "src/pipeline/mesh_or_repair.h"

#include <algorithm>
#include <iterator>
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
};

// The mesh of the surface as it is, or nothing and why.
Result<std::optional<TetMesh>> mesh_as_it_is(const Surface& surface, const MeshingOptions& options,
                                             const RunContext& context, Report& report,
                                             FirstFailure& failure) {
  SurfaceRun run(surface, {}, options, context, report.stages);
  report.input = run.input_record();  // also for who gives up during the diagnosis
  const Status usable = run.diagnose();
  report.input = run.input_record();
  report.certificate = run.certificate();
  Result<TetMesh> mesh = usable ? run.mesh() : Result<TetMesh>(usable.error());
  report.certificate = run.certificate();
  if (mesh) return std::optional(std::move(mesh).value());
  if (options.on_infeasible != OnInfeasible::repair || !repairable(mesh.error())) return mesh.error();
  failure = {mesh.error(), run.unglued(), run.parts()};
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
  for (const SubSurface& part : parts) {
    const double size = diagonal_of(part.surface) / diagonal;
    if (!options.sizes.at_vertex.empty()) {
      own.sizes.at_vertex.clear();
      for (const Index v : part.vertices) own.sizes.at_vertex.push_back(options.sizes.at_vertex[v]);
    }
    own.max_repair_move = std::min(1.0, options.max_repair_move / size);
    Report report;
    Result<MeshedSurface> r = mesh_or_repair(part.surface, own, context, report);
    if (!r || r.value().moves)
      std::move(report.stages.begin(), report.stages.end(), std::back_inserter(records));
    if (!r) return r;
    if (r.value().moves) moves.add(part, *r.value().moves, size);
    TetMesh& mesh = r.value().mesh;
    for (std::size_t v = 0; v < part.vertices.size(); ++v)
      repaired.V.row(part.vertices[v]) = mesh.V.row(static_cast<Eigen::Index>(v));
    meshes.push_back({part.vertices, std::move(mesh)});
  }
  // Each has been improved.
  const FinishingJob job{.input = repaired, .improve_degrees = 0, .context = context, .records = records};
  Result<TetMesh> whole = finish_given(job, united(repaired.V, meshes));
  if (!whole) return whole.error();
  return MeshedSurface{std::move(whole).value(), moves.all()};
}

Result<MeshedSurface> repair_whole(const Surface& surface, const MeshingOptions& options,
                                   const RunContext& context, std::vector<StageRecord>& records,
                                   const FirstFailure& first) {
  const RepairJob job{surface, options, context, records, diagonal_of(surface)};
  Result<RepairedMesh> repaired = mesh_repaired(job, first.error, first.unglued);
  if (!repaired) return repaired.error();
  RepairedMesh& r = repaired.value();
  if (Status s = opened(job, r); !s) return s.error();
  const bool good_already = r.state == RepairedMesh::State::finished &&
                            options.improve_degrees <= kAttemptDegrees && !options.sizes.any() &&
                            !options.sizes.coarse;
  Result<TetMesh> mesh =
      finish_given({r.surface, good_already ? 0 : options.improve_degrees, context, records, options.sizes},
                   std::move(r.mesh));
  if (!mesh) return mesh.error();
  return MeshedSurface{std::move(mesh).value(), std::move(r.moves)};
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
