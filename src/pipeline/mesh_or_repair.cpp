#include "src/pipeline/mesh_or_repair.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "kernels/core/box.h"
#include "kernels/predicates/predicates.h"
#include "overtet/verification.h"
#include "src/pipeline/component_meshing.h"
#include "src/pipeline/finishing.h"
#include "src/pipeline/refinement.h"
#include "src/pipeline/repair_route.h"
#include "src/pipeline/surface_run.h"
#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

// Why a surface has no mesh as it is, and what repairs need to know of it.
struct FirstFailure {
  Error error;
  Diagnosis diagnosis;
  std::optional<Eigen::Vector3d> unglued;
  std::vector<SubSurface> parts;
};

Error beyond_refining(Error e) {
  if (e.code == ErrorCode::infeasible) e.message += " Neither subdivided faces nor branch lines change that.";
  return e;
}

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
  if (options.on_infeasible == OnInfeasible::reject || !repairable(mesh.error())) return mesh.error();
  if (!run.diagnosis().topology.problems.empty()) return mesh.error();  // no move of vertices mends faces
  if (options.on_infeasible != OnInfeasible::repair && !refinable(mesh.error(), run.diagnosis()))
    return beyond_refining(mesh.error());
  failure = {mesh.error(), run.diagnosis(), run.unglued(), run.parts()};
  return std::optional<TetMesh>();
}

std::vector<Index> flipped_tets_of(const TetMesh& mesh) {
  std::vector<Index> flipped;
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    const auto at = [&](int k) { return mesh.V.data() + 3 * static_cast<std::ptrdiff_t>(mesh.T(t, k)); };
    if (orient3d(at(0), at(1), at(2), at(3)) <= 0) flipped.push_back(t);
  }
  return flipped;
}

std::vector<std::array<Index, 2>> branch_edges_of(const Surface& surface, const TetMesh& mesh,
                                                  const RunContext& context) {
  VerifyOptions options;
  options.allow_branches = true;
  return verify(surface, mesh, options, context).branch_edges;
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

// The refined surfaces of parts, put together.
class RefinedParts {
 public:
  explicit RefinedParts(const Surface& whole)
      : whole_(whole), pieces_(static_cast<std::size_t>(whole.F.rows())) {
    for (Index f = 0; f < whole.F.rows(); ++f) pieces_[f] = {{whole.F(f, 0), whole.F(f, 1), whole.F(f, 2)}};
  }

  // The numbers that the part's vertices, those added included, have in the whole.
  std::vector<Index> add(const SubSurface& part, const std::optional<RefinedSurface>& refined) {
    std::vector<Index> number = part.vertices;
    if (!refined) return number;
    const Surface& s = refined->surface;
    while (static_cast<Eigen::Index>(number.size()) < s.V.rows()) {
      added_.push_back(s.V.row(static_cast<Eigen::Index>(number.size())));
      number.push_back(static_cast<Index>(whole_.V.rows() + std::ssize(added_)) - 1);
    }
    for (const Index f : refined->subdivided) {
      out_.subdivided.push_back(part.faces[f]);
      pieces_[part.faces[f]].clear();
    }
    for (Index f = 0; f < s.F.rows(); ++f)
      if (std::binary_search(refined->subdivided.begin(), refined->subdivided.end(), refined->face[f]))
        pieces_[part.faces[refined->face[f]]].push_back(
            {number[s.F(f, 0)], number[s.F(f, 1)], number[s.F(f, 2)]});
    return number;
  }

  RefinedSurface all() {
    out_.surface.V.resize(whole_.V.rows() + std::ssize(added_), 3);
    out_.surface.V.topRows(whole_.V.rows()) = whole_.V;
    for (std::size_t i = 0; i < added_.size(); ++i)
      out_.surface.V.row(whole_.V.rows() + static_cast<Eigen::Index>(i)) = added_[i];
    std::sort(out_.subdivided.begin(), out_.subdivided.end());
    std::vector<std::array<Index, 3>> faces;
    for (std::size_t f = 0; f < pieces_.size(); ++f) {
      faces.insert(faces.end(), pieces_[f].begin(), pieces_[f].end());
      out_.face.resize(faces.size(), static_cast<Index>(f));
    }
    out_.surface.F.resize(std::ssize(faces), 3);
    for (Eigen::Index f = 0; f < out_.surface.F.rows(); ++f)
      for (int k = 0; k < 3; ++k) out_.surface.F(f, k) = faces[static_cast<std::size_t>(f)][k];
    return std::move(out_);
  }

 private:
  const Surface& whole_;
  std::vector<std::vector<std::array<Index, 3>>> pieces_;  // of each face
  std::vector<Eigen::RowVector3d> added_;
  RefinedSurface out_;
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

// Each part by itself, repaired or refined where it has no mesh. Nothing is said of how they lie to each
// other, so none is changed because of another one. Errors: of the first part that could not be helped.
Result<MeshedSurface> repair_by_parts(const Surface& surface, const std::vector<SubSurface>& parts,
                                      const MeshingOptions& options, const RunContext& context,
                                      std::vector<StageRecord>& records) {
  const double diagonal = diagonal_of(surface.V);
  MeshingOptions own = options;
  own.save_stages.clear();
  own.resume.clear();
  Surface repaired = surface;
  std::vector<PartMesh> meshes;
  MovesOfParts moves;
  RefinedParts refined(surface);
  OtherParts others;
  for (const SubSurface& part : parts) {
    const double size = diagonal_of(part.surface.V) / diagonal;
    if (!options.sizes.at_vertex.empty()) {
      own.sizes.at_vertex.clear();
      for (const Index v : part.vertices) own.sizes.at_vertex.push_back(options.sizes.at_vertex[v]);
    }
    own.max_repair_move = std::min(1.0, options.max_repair_move / size);
    Report report;
    Result<MeshedSurface> r = mesh_or_repair(part.surface, own, context, report);
    const bool as_it_is = r && !r.value().moves && !r.value().refined && r.value().branch_edges.empty();
    if (as_it_is)
      others.add(report.stages);
    else
      std::move(report.stages.begin(), report.stages.end(), std::back_inserter(records));
    if (!r) others.append_to(records);
    if (!r) return r;
    if (r.value().moves) moves.add(part, *r.value().moves, size);
    TetMesh& mesh = r.value().mesh;
    for (std::size_t v = 0; v < part.vertices.size(); ++v)
      repaired.V.row(part.vertices[v]) = mesh.V.row(static_cast<Eigen::Index>(v));
    meshes.push_back({refined.add(part, r.value().refined), std::move(mesh)});
  }
  others.append_to(records);
  MeshedSurface out;
  if (RefinedSurface all = refined.all(); !all.subdivided.empty())
    repaired = out.refined.emplace(std::move(all)).surface;
  if (options.on_infeasible == OnInfeasible::repair) out.moves = moves.all();
  // Each has been improved.
  const FinishingJob job{.input = repaired,
                         .improve_degrees = 0,
                         .context = context,
                         .records = records,
                         .allow_branches = options.on_infeasible == OnInfeasible::branch};
  Result<TetMesh> whole = finish_given(job, united(repaired.V, meshes).mesh);
  if (!whole) return whole.error();
  out.mesh = std::move(whole).value();
  if (job.allow_branches) out.branch_edges = branch_edges_of(surface, out.mesh, context);
  return out;
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
  const RepairJob job{surface, first.diagnosis, options, context, records, diagonal_of(surface.V)};
  Result<RepairedMesh> repaired = mesh_repaired(job, first.error, first.unglued);
  if (!repaired) return repaired.error();
  RepairedMesh& r = repaired.value();
  if (Status s = opened_wide(job, r); !s) return s.error();
  const bool good_already = r.state == RepairedMesh::State::finished &&
                            options.improve_degrees <= kAttemptDegrees && !options.sizes.any() &&
                            !options.sizes.coarse;
  FinishingJob last{r.surface, good_already ? 0 : options.improve_degrees, context, records};
  last.sizes = options.sizes;
  Result<TetMesh> mesh = finish_given(last, std::move(r.mesh));
  if (!mesh) return mesh.error();
  Result<TetMesh> settled = with_room_at_moved(job, measured(job, std::move(mesh).value()));
  if (!settled) return settled.error();
  return MeshedSurface{std::move(settled).value(), std::move(r.moves), {}, {}, {}};
}

Result<MeshedSurface> refine_whole(const Surface& surface, const MeshingOptions& options,
                                   const RunContext& context, std::vector<StageRecord>& records,
                                   const FirstFailure& first) {
  Result<RefinedMesh> refined =
      mesh_refined(surface, first.diagnosis, first.error, options, context, records);
  if (!refined) return refined.error();
  RefinedMesh& r = refined.value();
  MeshedSurface out{std::move(r.mesh), {}, {}, std::move(r.branch_edges), {}};
  if (!r.shape.subdivided.empty()) out.refined = std::move(r.shape);
  return out;
}

}  // namespace

Result<MeshedSurface> mesh_or_repair(const Surface& surface, const MeshingOptions& options,
                                     const RunContext& context, Report& report) {
  FirstFailure first;
  Result<std::optional<TetMesh>> mesh = mesh_as_it_is(surface, options, context, report, first);
  if (!mesh) return mesh.error();
  if (mesh.value()) {
    MeshedSurface out{std::move(*mesh.value()), {}, {}, {}, {}};
    if (options.allow_flips) out.flipped_tets = flipped_tets_of(out.mesh);
    if ((options.allow_branches || options.allow_flips) && out.flipped_tets.empty())
      out.branch_edges = branch_edges_of(surface, out.mesh, context);
    return out;
  }
  if (!first.parts.empty()) {
    Result<MeshedSurface> parts = repair_by_parts(surface, first.parts, options, context, report.stages);
    if (parts || !repairable(parts.error())) return parts;
    context.note(LogLevel::info, "The parts could not be changed one by one: " + parts.error().message);
  }
  if (options.on_infeasible != OnInfeasible::repair)
    return refine_whole(surface, options, context, report.stages, first);
  return repair_whole(surface, options, context, report.stages, first);
}

}  // namespace overtet
