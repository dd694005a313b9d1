#include "src/pipeline/surface_run.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <utility>

#include "overtet/verification.h"
#include "src/pipeline/finishing.h"
#include "src/pipeline/result_hash.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/strategies.h"

namespace overtet {

namespace {

// Why a surface that overlaps itself nowhere (so the solid can only be the region inside) but has two
// vertices in one place may have no mesh: the tets there cannot belong to both.
// Call only when the immersion route, which tells touching from outside from being pinched, has failed.
std::optional<Error> pinched_vertices(const Surface& input, const Diagnosis& diagnosis) {
  if (diagnosis.winding.max > 1) return std::nullopt;
  std::vector<Index> order(static_cast<std::size_t>(input.V.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto position = [&](Index v) {
    return std::array<double, 3>{input.V(v, 0), input.V(v, 1), input.V(v, 2)};
  };
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return position(a) != position(b) ? position(a) < position(b) : a < b; });
  for (std::size_t i = 0; i + 1 < order.size(); ++i)
    if (position(order[i]) == position(order[i + 1]))
      return Error{ErrorCode::unsolved,
                   "No tet mesh was found: vertices " + std::to_string(order[i]) + " and " +
                       std::to_string(order[i + 1]) +
                       " (counted from 0) are at the same point, and the solid seems to have no thickness "
                       "between them;" +
                       " move one of them a little.",
                   position(order[i])};
  return std::nullopt;
}

Eigen::Vector3d point_at(const std::array<double, 3>& place) { return {place[0], place[1], place[2]}; }

}  // namespace

SurfaceRun::SurfaceRun(const Surface& input, const SurfaceRunSetup& setup, const MeshingOptions& options,
                       const RunContext& context, std::vector<StageRecord>& records)
    : input_(input), setup_(setup), options_(options), context_(context), records_(records) {
  record_.vertices = input_.V.rows();
  record_.faces = input_.F.rows();
}

Status SurfaceRun::diagnose() {
  return timed_stage("diagnose", records_, context_, [&](StageRecord& record) -> Status {
    Result<Inspection> looked = inspect(input_, setup_.depth, context_);
    if (!looked) return looked.error();
    found_ = std::move(looked).value();
    if (found_.problem && may_try_all_the_same()) {
      context_.note(LogLevel::warning, found_.problem->message + " It is tried all the same.");
      found_.problem.reset();
    }
    const Diagnosis& d = found_.diagnosis;
    record_ = overtet::input_record(found_);
    record.figures = {{"pairs", record_.pairs},
                      {"verdict", std::string(verdict_name(d.verdict))},
                      {"wound_edges", static_cast<std::int64_t>(d.wound.edges.size())},
                      {"pairs_seconds", d.times.pairs},
                      {"hinges_seconds", d.times.hinges},
                      {"winding_seconds", d.times.winding},
                      {"wound_edges_seconds", d.times.wound_edges}};
    if (found_.problem) return *found_.problem;
    surface_ = input_;
    back_into_unit_box(surface_.V, found_.box);
    return success();
  });
}

// A certificate says that no mesh keeps all promises; one that need not may still be made.
bool SurfaceRun::may_try_all_the_same() const {
  if (found_.problem->code != ErrorCode::infeasible || !found_.diagnosis.certificate) return false;
  return options_.allow_flips ||
         (options_.allow_branches && !forbids_branch_lines(*found_.diagnosis.certificate));
}

// Whether there can be a mesh at all, once a strategy has failed; looked at once.
Status SurfaceRun::look_closer() {
  if (std::exchange(looked_closer_, true)) return success();
  return timed_stage("gluing", records_, context_, [&](StageRecord&) -> Status {
    if (Status s = look_for_conflict(input_, found_, context_); !s) return s;
    return found_.problem ? Status(*found_.problem) : success();
  });
}

// Why no further strategy need be tried; none: go on.
std::optional<Error> SurfaceRun::final_reason(const Error& e) {
  const auto pinched = pinched_vertices(input_, found_.diagnosis);
  if (pinched && pinched->place) unglued_ = point_at(*pinched->place);
  if (setup_.origin != SurfaceRunSetup::Origin::repaired)
    if (Status s = look_closer(); !s) return s.error();
  if (pinched) return pinched;
  if (e.reason != ErrorReason::exhausted) return std::nullopt;
  return Error{
      ErrorCode::unsolved,
      "No tet mesh was found: " + e.message +
          " With its crossings rounded to doubles, every gluing has been tried, with every edge that can "
          "be wound, so other routes were left out.",
      e.place, ErrorReason::exhausted};
}

Result<TetMesh> SurfaceRun::try_strategies() {
  MeshingJob job{surface_,
                 found_.box,
                 found_.diagnosis,
                 context_,
                 records_,
                 options_.preset,
                 setup_.patience,
                 save_ ? &*save_ : nullptr,
                 resume_ ? &*resume_ : nullptr,
                 film_ ? &*film_ : nullptr,
                 std::nullopt,
                 options_.recipe,
                 options_.flow_map,
                 {options_.allow_branches, options_.allow_flips}};
  const bool first_only =
      setup_.origin != SurfaceRunSetup::Origin::read && options_.preset == Preset::standard;
  std::string told;
  ErrorCode code = ErrorCode::unsolved;
  for (const Strategy& strategy : strategies()) {
    if (first_only && !told.empty()) break;
    if (!strategy.applies(job)) continue;
    Result<Draft> draft = strategy.run(job);
    Result<TetMesh> mesh = draft ? finish(std::move(draft).value()) : Result<TetMesh>(draft.error());
    if (mesh) return mesh;
    const Error& e = mesh.error();
    if (strategy.failure == Strategy::Failure::of_gluing && e.place) unglued_ = point_at(*e.place);
    if (ends_run(e) || e.code == ErrorCode::bad_input) return mesh;
    if (e.code == ErrorCode::internal)
      code = e.code;  // another strategy may still do; if none does, this is why
    const std::string line = std::string("Route ") + strategy.name + ": " + e.message;
    context_.note(LogLevel::info, line);
    if (strategy.failure == Strategy::Failure::of_a_part) {
      if (e.code == ErrorCode::infeasible) job.part_without_mesh = e;
      continue;
    }
    if (options_.preset != Preset::paper)
      if (auto reason = final_reason(e)) return *reason;
    told += (told.empty() ? "" : " ") + line;
  }
  if (!found_.diagnosis.wound.complete()) told = found_.diagnosis.wound.explanation + " " + told;
  if (job.part_without_mesh) told += " " + job.part_without_mesh->message;
  return Error{code, "No tet mesh was found. " + told};
}

// A mesh that was saved before the quality pass.
Result<TetMesh> SurfaceRun::finish_saved() {
  Result<Draft> draft = resume_->load_draft("mapped", static_cast<Index>(surface_.V.rows()));
  if (!draft) return draft.error();
  VerifyOptions lenient;
  lenient.allow_branches = options_.allow_branches;
  if (!options_.allow_flips && !verify(surface_, draft.value().mesh, lenient, context_).ok()) {
    if (auto stop = context_.stop()) return *stop;
    return Error{ErrorCode::bad_input,
                 "The saved stage mapped is damaged: it does not fit the input. Do not resume from it."};
  }
  return finish(std::move(draft).value());
}

Result<TetMesh> SurfaceRun::finish(Draft draft) {
  if (save_)
    if (Status s = save_->save("mapped", draft); !s) return s.error();
  return overtet::finish({.input = input_,
                          .improve_degrees = options_.improve_degrees,
                          .context = context_,
                          .records = records_,
                          .sizes = options_.sizes,
                          .allow_branches = options_.allow_branches,
                          .placed = draft.placed,
                          .allow_flips = options_.allow_flips},
                         found_.box, std::move(draft.mesh));
}

Status SurfaceRun::open_files() {
  if (!options_.save_flow.empty()) {
    Result<FlowSeries> film = FlowSeries::create(options_.save_flow, found_.box);
    if (!film) return film.error();
    film_ = std::move(film).value();
  }
  if (options_.resume.empty() && options_.save_stages.empty()) return success();
  const std::string hash = hash_of(input_);
  if (!options_.resume.empty()) {
    Result<StageFiles> files = StageFiles::open(options_.resume, hash, found_.box);
    if (!files) return files.error();
    resume_ = std::move(files).value();
  }
  if (!options_.save_stages.empty()) {
    Result<StageFiles> files = StageFiles::create(options_.save_stages, hash, found_.box);
    if (!files) return files.error();
    save_ = std::move(files).value();
  }
  return success();
}

Result<TetMesh> SurfaceRun::mesh() {
  if (Status s = open_files(); !s) return s.error();
  return resume_ && resume_->has("mapped") ? finish_saved() : try_strategies();
}

Result<TetMesh> SurfaceRun::go() {
  if (Status s = diagnose(); !s) return s.error();
  return mesh();
}

}  // namespace overtet
