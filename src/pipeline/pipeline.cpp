#include "src/pipeline/pipeline.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <exception>
#include <functional>
#include <iterator>
#include <new>
#include <numeric>
#include <optional>
#include <utility>

#include "kernels/parallel/parallel.h"
#include "src/immersion/immersion.h"
#include "src/improve/improve.h"
#include "src/mesh/tet_complex.h"
#include "src/pipeline/component_meshing.h"
#include "src/pipeline/flow_route.h"
#include "src/pipeline/inspection.h"
#include "src/pipeline/locked_patch.h"
#include "src/pipeline/repair_route.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/stage_files.h"
#include "src/pipeline/unit_box.h"
#include "src/run/run_monitor.h"
#include "src/verify/verify.h"

namespace overtet {

namespace {

// With TetGen, for what a repair can do without: its flips nearly always end in less.
constexpr double kLuxuryPatience = 0.3;

double seconds_since(RunContext::Clock::time_point start) {
  return std::chrono::duration<double>(RunContext::Clock::now() - start).count();
}

class Hash {
 public:
  void add(const void* data, std::size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) value_ = (value_ ^ p[i]) * 0x100000001b3ull;
  }
  void add(std::int64_t x) { add(&x, sizeof x); }
  template <class Matrix>
  void add_matrix(const Matrix& m) {
    add(static_cast<std::int64_t>(m.rows()));
    add(m.data(), sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(m.size()));
  }
  std::string text() const {
    char digits[24];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value_));
    return digits;
  }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ull;
};

// One run: the state that the stages hand on, and what is written down about them.
class Run {
 public:
  // repaired: `input` has been repaired, so that what is wrong with it may be repaired again.
  // patience: with TetGen.
  Run(const Surface& input, bool repaired, const PipelineOptions& options, const RunContext& context,
      PipelineResult& result, double patience = 1)
      : input_(input),
        repaired_(repaired),
        patience_(patience),
        options_(options),
        context_(context),
        result_(result),
        report_(result.report) {}

  Status go();
  Status finish_given(TetMesh mesh);

  // Where the sheets could not be glued, in the input's space.
  const std::optional<Eigen::Vector3d>& unglued() const { return unglued_; }
  std::vector<PartSurface> parts() const { return parts_of(input_, found_.diagnosis); }

 private:
  template <class F>
  auto stage(const char* name, F&& f) {
    return timed_stage(name, report_.stages, context_, std::forward<F>(f));
  }

  Status diagnose();
  Status look_closer();
  std::optional<Error> pinched_vertices() const;
  Status try_routes();
  Status finish_saved();
  Result<TetMesh> mesh_clean();
  Result<TetMesh> mesh_immersed();
  Error in_input_space(Error error) const;
  Status finish(TetMesh mesh);
  TetMesh improved(const TetMesh& mesh);
  template <class Geometry>
  Status save(const char* name, const Geometry& geometry) {
    return save_ ? save_->save(name, geometry) : success();
  }

  const Surface& input_;
  const bool repaired_;
  const double patience_;
  const PipelineOptions& options_;
  const RunContext& context_;
  PipelineResult& result_;
  Report& report_;

  Surface surface_;  // in the unit box
  UnitBox box_;
  Inspection found_;
  std::optional<StageFiles> save_, resume_;
  std::optional<Eigen::Vector3d> unglued_;
  std::optional<Error> bad_part_;  // why one has no mesh by itself: then all together seldom have
  bool looked_closer_ = false;
};

Status Run::diagnose() {
  return stage("diagnose", [&](StageRecord& record) -> Status {
    report_.input.vertices = input_.V.rows();
    report_.input.faces = input_.F.rows();
    Result<Inspection> looked = inspect(input_, false, context_);
    if (!looked) return looked.error();
    found_ = std::move(looked).value();
    const Diagnosis& d = found_.diagnosis;
    report_.input = input_record(found_);
    report_.witness = found_.witness;
    record.figures = {{"pairs", report_.input.pairs},
                      {"verdict", std::string(verdict_name(d.verdict))},
                      {"wound_edges", static_cast<std::int64_t>(d.wound.edges.size())},
                      {"pairs_seconds", d.times.pairs},
                      {"hinges_seconds", d.times.hinges},
                      {"winding_seconds", d.times.winding},
                      {"wound_edges_seconds", d.times.wound_edges}};
    if (found_.problem) return *found_.problem;
    surface_ = input_;
    box_ = found_.box;
    back_into_unit_box(surface_.V, box_);
    return success();
  });
}

// Whether there can be a mesh at all, once a route has failed; looked at once.
Status Run::look_closer() {
  if (looked_closer_) return success();
  looked_closer_ = true;
  return stage("gluing", [&](StageRecord&) -> Status {
    if (Status s = look_for_conflict(input_, found_, context_); !s) return s;
    report_.witness = found_.witness;
    return found_.problem ? Status(*found_.problem) : success();
  });
}

// Why a surface that overlaps itself nowhere (so the solid can only be the region inside) but has two
// vertices in one place has no mesh: the tets there cannot belong to both.
// Call only when the immersion route, which tells touching from outside from being pinched, has failed.
std::optional<Error> Run::pinched_vertices() const {
  if (found_.diagnosis.winding.max > 1) return std::nullopt;
  std::vector<Index> order(static_cast<std::size_t>(input_.V.rows()));
  std::iota(order.begin(), order.end(), 0);
  const auto position = [&](Index v) {
    return std::array<double, 3>{input_.V(v, 0), input_.V(v, 1), input_.V(v, 2)};
  };
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return position(a) != position(b) ? position(a) < position(b) : a < b; });
  for (std::size_t i = 0; i + 1 < order.size(); ++i)
    if (position(order[i]) == position(order[i + 1]))
      return Error{ErrorCode::bad_input,
                   "Vertices " + std::to_string(order[i]) + " and " + std::to_string(order[i + 1]) +
                       " are at the same point, and the solid has no thickness between them;" +
                       " move one of them a little.",
                   position(order[i])};
  return std::nullopt;
}

// The routes in turn, until one leads to a mesh that passes the check.
Status Run::try_routes() {
  struct Route {
    const char* name;
    std::function<Result<TetMesh>()> run;
  };
  std::vector<Route> routes;
  if (is_plain(found_.diagnosis)) routes.push_back({"tet mesh", [&] { return mesh_clean(); }});
  if (options_.preset == Preset::standard && has_parts(surface_, found_.diagnosis))
    routes.push_back({"parts", [&] {
                        return mesh_by_parts({surface_, found_.diagnosis, context_, report_.stages});
                      }});
  if (options_.preset == Preset::standard) routes.push_back({"immersion", [&] { return mesh_immersed(); }});
  routes.push_back({"flow", [&] {
                      Result<TetMesh> mesh =
                          mesh_by_flow({surface_, found_.diagnosis, context_, report_.stages,
                                        save_ ? &*save_ : nullptr, resume_ ? &*resume_ : nullptr});
                      return mesh ? std::move(mesh) : Result<TetMesh>(in_input_space(mesh.error()));
                    }});
  std::string told;
  ErrorCode code = ErrorCode::unsolved;
  for (const Route& route : routes) {
    // What flows until nothing crosses fills each part by itself: of no use where one of them has no mesh.
    if (bad_part_ && std::string(route.name) == "flow") break;
    // A repaired surface is repaired again where the sheets could not be glued: no flows.
    if (!told.empty() && repaired_ && options_.preset == Preset::standard) break;
    Result<TetMesh> mesh = route.run();
    Status done = mesh ? finish(std::move(mesh).value()) : Status(mesh.error());
    if (done) return done;
    const Error& e = done.error();
    if (e.code == ErrorCode::limit || e.code == ErrorCode::interrupted || e.code == ErrorCode::io ||
        e.code == ErrorCode::bad_input)
      return done;
    if (e.code == ErrorCode::internal)
      code = e.code;  // another route may still do; if none does, this is why
    context_.note(LogLevel::info, std::string("Route ") + route.name + ": " + e.message);
    if (std::string(route.name) == "parts") {
      if (e.code == ErrorCode::infeasible) bad_part_ = e;
      continue;  // the whole is still to be tried
    }
    if (const auto pinched = pinched_vertices()) {
      if (pinched->place)
        unglued_ = Eigen::Vector3d((*pinched->place)[0], (*pinched->place)[1], (*pinched->place)[2]);
      return *pinched;
    }
    if (!repaired_)
      if (Status s = look_closer(); !s) return s;
    if (e.reason == ErrorReason::exhausted)
      return Error{ErrorCode::unsolved,
                   "No tet mesh was found: " + e.message +
                       " All gluings have been tried, with all edges wound that could be, so no other way "
                       "would find one.",
                   e.place, ErrorReason::exhausted};
    told += (told.empty() ? "" : " ") + std::string("Route ") + route.name + ": " + e.message;
  }
  if (!found_.diagnosis.wound.complete()) told = found_.diagnosis.wound.explanation + " " + told;
  if (bad_part_) told += " " + bad_part_->message;
  return Error{code, "No tet mesh was found. " + told};
}

// A mesh that was saved before the quality pass.
Status Run::finish_saved() {
  Result<TetMesh> mesh = resume_->load_mesh("mapped", static_cast<Index>(surface_.V.rows()));
  if (!mesh) return mesh.error();
  if (!verify(surface_, mesh.value(), {}, context_).ok()) {
    if (auto stop = context_.stop()) return *stop;
    return Error{ErrorCode::bad_input,
                 "The stage mapped to resume from does not fit the input; it is damaged."};
  }
  return finish(std::move(mesh).value());
}

// An error of a stage, which works in the unit box, in the input's space; the message names the place, too.
Error Run::in_input_space(Error error) const {
  if (!error.place) return error;
  VertexMatrix p(1, 3);
  p << (*error.place)[0], (*error.place)[1], (*error.place)[2];
  out_of_unit_box(p, box_);
  error.place = {p(0, 0), p(0, 1), p(0, 2)};
  char where[128];
  Index vertex = 0;
  while (vertex < input_.V.rows() && input_.V.row(vertex) != p.row(0)) ++vertex;
  if (vertex < input_.V.rows())
    std::snprintf(where, sizeof where, " at vertex %d (%.6g, %.6g, %.6g).", vertex, p(0, 0), p(0, 1),
                  p(0, 2));
  else
    std::snprintf(where, sizeof where, " near (%.6g, %.6g, %.6g).", p(0, 0), p(0, 1), p(0, 2));
  if (!error.message.empty() && error.message.back() == '.') error.message.pop_back();
  error.message += where;
  return error;
}

Result<TetMesh> Run::mesh_immersed() {
  return stage("immersion", [&](StageRecord& record) -> Result<TetMesh> {
    const Diagnosis& d = found_.diagnosis;
    ImmersionOptions options;
    options.patience = bad_part_ ? std::min(patience_, kLuxuryPatience) : patience_;
    Result<ImmersionResult> r = immerse(surface_, d.pairs, d.wound.edges, options, context_);
    if (!r) {
      Error error = in_input_space(r.error());
      if (error.place) {
        unglued_ = Eigen::Vector3d((*error.place)[0], (*error.place)[1], (*error.place)[2]);
        const auto& p = *r.error().place;
        const LockedPatch patch = patch_around(surface_, d.pairs, Eigen::Vector3d(p[0], p[1], p[2]));
        if (Status s = save("locked", patch.surface); !s) return s.error();
      }
      return error;
    }
    const ImmersionResult& x = r.value();
    if (Status s = save("arrangement", Surface{x.arrangement.V, x.arrangement.F}); !s) return s.error();
    if (Status s = save("cover", x.cover); !s) return s.error();
    record.iterations = x.search_nodes;
    record.figures = {{"cells", std::int64_t{x.cells}},
                      {"regions", std::int64_t{x.regions}},
                      {"winding_max", std::int64_t{x.winding_max}},
                      {"facets", std::int64_t{x.arrangement.F.rows()}},
                      {"points", std::int64_t{x.arrangement.V.rows()}},
                      {"rounds", std::int64_t{x.arrangement.rounds}},
                      {"missing_facets", std::int64_t{x.missing_facets}},
                      {"tetgen_facets", std::int64_t{x.tetgen_facets}},
                      {"tetgen_parts", std::int64_t{x.tetgen_parts}},
                      {"steiner_points", std::int64_t{x.steiner_points}},
                      {"boundary_points", std::int64_t{x.boundary_points}},
                      {"refined_edges", std::int64_t{x.refined_edges}},
                      {"tets", std::int64_t{x.mesh.T.rows()}},
                      {"arrangement_seconds", x.arrangement_seconds},
                      {"tet_mesh_seconds", x.tet_mesh_seconds},
                      {"sheets_seconds", x.sheets_seconds},
                      {"boundary_seconds", x.boundary_seconds}};
    return std::move(r.value().mesh);
  });
}

Result<TetMesh> Run::mesh_clean() {
  return stage("tet_mesh", [&](StageRecord& record) -> Result<TetMesh> {
    Result<TetMesh> mesh = mesh_plain(surface_, context_);
    if (mesh) record.figures.emplace_back("tets", std::int64_t{mesh.value().T.rows()});
    return mesh;
  });
}

// The mesh after the quality pass; the mesh itself when the pass cannot be made.
TetMesh Run::improved(const TetMesh& mesh) {
  if (options_.improve_degrees <= 0) return mesh;
  TetMesh better = mesh;
  const Status done = stage("improve", [&](StageRecord& record) -> Status {
    ImproveOptions options;
    options.target_degrees = options_.improve_degrees;
    Result<ImproveResult> r = improve(better, options, context_);
    if (!r) return r.error();
    const ImproveResult& x = r.value();
    if (x.end == ImproveResult::End::time_over)
      context_.note(LogLevel::warning, "The quality pass ended early, at the time limit.");
    record.iterations = static_cast<std::int64_t>(x.passes.size());
    ImprovePass all;
    for (const ImprovePass& pass : x.passes) {
      all.removed_edges += pass.removed_edges;
      all.flips += pass.flips;
      all.smoothed += pass.smoothed;
      all.collapsed += pass.collapsed;
      all.inserted += pass.inserted;
    }
    record.figures = {
        {"refined_vertices", x.refined},
        {"removed_edges", all.removed_edges},
        {"flips", all.flips},
        {"smoothed", all.smoothed},
        {"contracted_edges", all.collapsed},
        {"inserted_vertices", all.inserted},
        {"lifted", std::int64_t{x.lifted}},
        {"traded", x.traded},
        {"parts", std::int64_t{x.rounds.empty() ? 0 : *std::max_element(x.rounds.begin(), x.rounds.end())}},
        {"tets", std::int64_t{better.T.rows()}}};
    return success();
  });
  return done ? better : mesh;
}

// Improves, scales back, checks and hands out.
Status Run::finish(TetMesh mesh) {
  if (Status s = save("mapped", mesh); !s) return s;
  const auto check = [&](const TetMesh& m) {
    return stage("verify", [&](StageRecord& record) -> Status {
      const VerifyResult v = verify(input_, m, {}, context_);
      if (!v.complete) return context_.stop().value_or(Error{ErrorCode::interrupted, "Interrupted."});
      record.figures.emplace_back("tets", v.tets);
      if (!v.ok()) return Error{ErrorCode::unsolved, "The tet mesh that was found is wrong: " + v.summary()};
      return success();
    });
  };
  TetMesh result = improved(mesh);
  if (auto stop = context_.stop()) return *stop;
  out_of_unit_box(result.V, box_);
  Status good = check(result);
  if (!good && good.error().code == ErrorCode::unsolved && options_.improve_degrees > 0) {
    // The quality pass is a luxury: fall back to the mesh before it.
    context_.note(LogLevel::warning,
                  "The mesh after the quality pass failed the check: " + good.error().message);
    result = std::move(mesh);
    out_of_unit_box(result.V, box_);
    good = check(result);
  }
  if (!good) return good;
  parallel_invoke([&] { report_.quality = tet_quality(result); },
                  [&] { report_.result_hash = hash_of(result); });
  result_.mesh = std::move(result);
  return success();
}

Status Run::go() {
  if (Status s = diagnose(); !s) return s;
  const std::string hash = options_.resume.empty() && options_.save_stages.empty() ? "" : hash_of(input_);
  if (!options_.resume.empty()) {
    Result<StageFiles> files = StageFiles::open(options_.resume, hash, box_);
    if (!files) return files.error();
    resume_ = std::move(files).value();
  }
  if (!options_.save_stages.empty()) {
    Result<StageFiles> files = StageFiles::create(options_.save_stages, hash, box_);
    if (!files) return files.error();
    save_ = std::move(files).value();
  }
  if (resume_ && resume_->has("mapped")) return finish_saved();
  return try_routes();
}

// A mesh that was made before; in the input's space.
Status Run::finish_given(TetMesh mesh) {
  surface_ = input_;
  Result<UnitBox> box = into_unit_box(surface_.V);
  if (!box) return box.error();
  box_ = box.value();
  back_into_unit_box(mesh.V, box_);
  return finish(std::move(mesh));
}

double diagonal_of(const Surface& surface) {
  return (surface.V.colwise().maxCoeff() - surface.V.colwise().minCoeff()).norm();
}

Status run_repairing(const Surface& surface, const PipelineOptions& options, const RunContext& context,
                     PipelineResult& result);

// Each part by itself, repaired where it has no mesh. Nothing is said of how they lie to each other, so none
// is moved because of another one. Errors: of the first part that could not be repaired.
Status repair_by_parts(const Surface& surface, const std::vector<PartSurface>& parts,
                       const PipelineOptions& options, const RunContext& context, PipelineResult& result) {
  Report& report = result.report;
  const double diagonal = diagonal_of(surface);
  PipelineOptions own = options;
  own.save_stages.clear();
  own.resume.clear();
  Surface repaired = surface;
  std::vector<PartMesh> meshes;
  std::vector<std::int64_t> moved;
  double farthest = 0, sum = 0;
  for (const PartSurface& part : parts) {
    const double size = diagonal_of(part.surface) / diagonal;
    own.max_repair_move = std::min(1.0, options.max_repair_move / size);
    PipelineResult r;
    const Status done = run_repairing(part.surface, own, context, r);
    if (r.report.status != RunStatus::exact)
      std::move(r.report.stages.begin(), r.report.stages.end(), std::back_inserter(report.stages));
    if (!done) return done;
    for (const std::int64_t v : r.report.moved_ids) moved.push_back(part.vertices[v]);
    farthest = std::max(farthest, size * r.report.max_relative_move);
    sum += size * r.report.mean_relative_move * static_cast<double>(r.report.moved_vertices);
    for (std::size_t v = 0; v < part.vertices.size(); ++v)
      repaired.V.row(part.vertices[v]) = r.mesh.V.row(static_cast<Eigen::Index>(v));
    meshes.push_back({part.vertices, std::move(r.mesh)});
  }
  own.improve_degrees = 0;  // each has been improved
  Run run(repaired, true, own, context, result);
  if (Status s = run.finish_given(united(repaired.V, meshes)); !s) return s;
  std::sort(moved.begin(), moved.end());
  report.status = RunStatus::repaired;
  report.witness.reset();
  report.moved_vertices = static_cast<std::int64_t>(moved.size());
  report.max_relative_move = farthest;
  report.mean_relative_move = moved.empty() ? 0 : sum / static_cast<double>(moved.size());
  report.moved_ids = std::move(moved);
  return success();
}

// Runs on the surface, and where that finds no mesh and repairing is asked for, on repaired ones.
Status run_repairing(const Surface& surface, const PipelineOptions& options, const RunContext& context,
                     PipelineResult& result) {
  Report& report = result.report;
  Status first = success();
  std::optional<Eigen::Vector3d> unglued;
  std::vector<PartSurface> parts;
  const bool may_repair = options.on_infeasible == OnInfeasible::repair;
  {
    Run run(surface, false, options, context, result);
    first = run.go();
    unglued = run.unglued();
    if (!first && may_repair && repairable(first.error())) parts = run.parts();
  }
  if (first) {
    report.status = RunStatus::exact;
    return first;
  }
  if (!may_repair || !repairable(first.error())) return first;
  if (!parts.empty()) {
    const Status done = repair_by_parts(surface, parts, options, context, result);
    if (done || !repairable(done.error())) return done;
    context.note(LogLevel::info,
                 "Repair: one by one the parts could not be repaired: " + done.error().message);
  }
  const InputRecord input = report.input;
  const std::optional<WitnessRecord> witness = report.witness;
  // What is pulled back to the input locks early where it is made of bad tets. Always the same, so that the
  // repaired surface does not depend on what becomes of the mesh afterwards.
  PipelineOptions to_pull = options, as_it_is = options;
  to_pull.improve_degrees = PipelineOptions().improve_degrees;
  as_it_is.improve_degrees = 0;
  const auto mesh_of = [&](const Surface& moved, bool a_luxury) {
    MeshAttempt attempt;
    Run run(moved, true, to_pull, context, result, a_luxury ? kLuxuryPatience : 1);
    attempt.done = run.go();
    attempt.unglued = run.unglued();
    attempt.mesh = std::move(result.mesh);
    report.input = input;
    report.witness = witness;
    return attempt;
  };
  const auto improve_of = [&](const Surface& moved, TetMesh mesh) {
    MeshAttempt attempt;
    Run run(moved, true, to_pull, context, result);
    attempt.done = run.finish_given(std::move(mesh));
    attempt.mesh = std::move(result.mesh);
    return attempt;
  };
  Result<RepairedMesh> repaired =
      mesh_repaired({surface, options.max_repair_move, context, report.stages, mesh_of, improve_of},
                    first.error(), unglued);
  report.input = input;
  report.witness = witness;
  if (!repaired) return repaired.error();
  RepairedMesh& r = repaired.value();
  const bool good_already = !r.pulled && options.improve_degrees <= to_pull.improve_degrees;
  Run run(r.surface, true, good_already ? as_it_is : options, context, result);
  if (Status s = run.finish_given(std::move(r.mesh)); !s) return s;
  report.status = RunStatus::repaired;
  report.witness.reset();
  report.moved_vertices = static_cast<std::int64_t>(r.moved.size());
  report.max_relative_move = r.max_relative;
  report.mean_relative_move = r.mean_relative;
  report.moved_ids.assign(r.moved.begin(), r.moved.end());
  return success();
}

}  // namespace

Status PipelineOptions::validate() const {
  if (!(improve_degrees >= 0 && improve_degrees <= 40))
    return Error{ErrorCode::usage, "The angle for the quality pass must lie between 0 and 40 degrees."};
  if (!(max_repair_move > 0 && max_repair_move <= 1))
    return Error{ErrorCode::usage, "The largest move must be a part of the diagonal between 0 and 1."};
  return success();
}

RunStatus status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::bad_input:
      return RunStatus::bad_input;
    case ErrorCode::unsolved:
      return RunStatus::unsolved;
    case ErrorCode::infeasible:
      return RunStatus::infeasible;
    case ErrorCode::limit:
      return RunStatus::limit;
    case ErrorCode::interrupted:
      return RunStatus::interrupted;
    case ErrorCode::usage:
    case ErrorCode::io:
    case ErrorCode::internal:
      return RunStatus::failed;
  }
  return RunStatus::failed;
}

std::string hash_of(const TetMesh& mesh) {
  Hash h;
  h.add_matrix(mesh.V);
  h.add_matrix(mesh.T);
  return h.text();
}

std::string hash_of(const Surface& surface) {
  Hash h;
  h.add_matrix(surface.V);
  h.add_matrix(surface.F);
  return h.text();
}

PipelineResult run_pipeline(const Surface& surface, const PipelineOptions& options, const RunContext& outer) {
  PipelineResult result;
  const auto start = RunContext::Clock::now();
  const auto fail = [&](Error e) {
    result.report.status = status_of(e.code);
    result.report.message = e.message;
    result.error = std::move(e);
  };
  if (Status s = options.validate(); !s) {
    fail(s.error());
    return result;
  }
  RunMonitor watch(outer);
  try {
    const ScopedThreads threads(outer.threads);
    if (Status s = run_repairing(surface, options, watch.context(), result); !s.ok())
      fail(watch.explained(s.error()));
  } catch (const std::bad_alloc&) {
    fail({ErrorCode::limit, "There is not enough memory for this model."});
  } catch (const std::exception& e) {
    fail({ErrorCode::internal, std::string("Internal error, please report it: ") + e.what() + "."});
  }
  if (!result.ok()) {
    result.mesh = {};
    result.report.moved_vertices = 0;
    result.report.max_relative_move = result.report.mean_relative_move = 0;
    result.report.moved_ids.clear();
  }
  result.report.seconds = seconds_since(start);
  result.report.peak_rss_bytes = watch.peak_bytes();
  return result;
}

}  // namespace overtet
