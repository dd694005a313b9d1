#include "src/pipeline/finishing.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "overtet/verification.h"
#include "src/improve/improve.h"
#include "src/improve/set_apart.h"
#include "src/mesh/tet_complex.h"
#include "src/pipeline/stage_clock.h"

namespace overtet {

namespace {

void write_down(const ImproveResult& x, const TetMesh& mesh, StageRecord& record) {
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
      {"thinned_vertices", x.thinned},
      {"refined_vertices", x.refined},
      {"removed_edges", all.removed_edges},
      {"flips", all.flips},
      {"smoothed", all.smoothed},
      {"contracted_edges", all.collapsed},
      {"inserted_vertices", all.inserted},
      {"lifted", std::int64_t{x.lifted}},
      {"coarsened_vertices", x.coarsened},
      {"traded", x.traded},
      {"parts", std::int64_t{x.rounds.empty() ? 0 : *std::max_element(x.rounds.begin(), x.rounds.end())}},
      {"tets", std::int64_t{mesh.T.rows()}}};
}

SizeOptions in_box(const TetSizes& sizes, const UnitBox& box) {
  SizeOptions o;
  if (sizes.max_volume > 0) o.max_volume = sizes.max_volume;
  if (sizes.max_edge > 0) o.max_edge = sizes.max_edge;
  o.at_surface = sizes.at_vertex;
  for (int k = 0; k < 3; ++k) o.unit[k] = std::ldexp(1, -box.exponent[k]);
  return o;
}

void say_what_is_too_large(const FinishingJob& job, const ImproveResult& r, StageRecord& record) {
  if (!job.sizes.any()) return;
  record.figures.emplace_back("too_large", r.too_large);
  record.figures.emplace_back("fixed_too_long", r.fixed_too_long);
  if (r.fixed_too_long > 0)
    job.context.note(LogLevel::warning,
                     std::to_string(r.fixed_too_long) +
                         " edges of the surface are longer than the sizes asked for; they stay, and "
                         "tets near them are larger.");
  if (r.too_large > 0)
    job.context.note(LogLevel::warning, std::to_string(r.too_large) + " tets are larger than asked.");
}

// The mesh after the quality pass; the mesh itself when the pass cannot be made.
TetMesh improved(const FinishingJob& job, const UnitBox& box, const TetMesh& mesh) {
  if (job.improve_degrees <= 0) return mesh;
  TetMesh better = mesh;
  const Status done = timed_stage("improve", job.records, job.context, [&](StageRecord& record) -> Status {
    ImproveOptions options;
    options.target_degrees = job.improve_degrees;
    options.sizes = in_box(job.sizes, box);
    options.coarse = job.sizes.coarse;
    options.placed = job.placed;
    Result<ImproveResult> r = improve(better, options, job.context);
    if (!r) return r.error();
    if (r.value().end == ImproveResult::End::time_over)
      job.context.note(LogLevel::warning, "The quality pass ended early because of the time limit.");
    write_down(r.value(), better, record);
    say_what_is_too_large(job, r.value(), record);
    return success();
  });
  if (!done && (job.sizes.any() || job.sizes.coarse) && !job.context.stop())
    job.context.note(LogLevel::warning, "The tets do not have the sizes asked for: " + done.error().message);
  return done ? better : mesh;
}

// Vertices that coincide though the surface's do not step aside.
void make_points_distinct(const FinishingJob& job, TetMesh& mesh) {
  const Status done = timed_stage("set_apart", job.records, job.context, [&](StageRecord& record) -> Status {
    const SetApartResult r = set_apart(mesh, job.context);
    record.figures = {{"moved", r.moved}, {"stuck", r.stuck}, {"forced", r.forced}};
    if (r.forced > 0) {
      const auto at = job.input.V.row(r.first);
      std::ostringstream place;
      place << at[0] << ", " << at[1] << ", " << at[2];
      job.context.note(
          LogLevel::warning,
          std::to_string(r.forced) + " vertices of the surface lie in one place with another one (first " +
              std::to_string(r.first) + " and " + std::to_string(r.second) + ", counted from 0, at (" +
              place.str() + ")) and must stay there; programs that merge equal points would glue the mesh.");
    }
    return success();
  });
  (void)done;
}

Status check(const FinishingJob& job, const TetMesh& mesh) {
  return timed_stage("verify", job.records, job.context, [&](StageRecord& record) -> Status {
    VerifyOptions options;
    options.allow_branches = job.allow_branches || job.allow_flips;
    const VerifyResult v = verify(job.input, mesh, options, job.context);
    if (!v.complete) return job.context.stop().value_or(Error{ErrorCode::interrupted, "Interrupted."});
    record.figures.emplace_back("tets", v.tets);
    const auto excused = [&](const VerifyFailure& f) {
      return job.allow_flips && (f.rule == Rule::R4 || f.rule == Rule::R6);
    };
    if (!std::all_of(v.failures.begin(), v.failures.end(), excused))
      return Error{ErrorCode::unsolved, "The tet mesh that was found is wrong: " + v.summary()};
    return success();
  });
}

}  // namespace

Result<TetMesh> finish(const FinishingJob& job, const UnitBox& box, TetMesh mesh) {
  if (job.allow_flips && first_not_positive(mesh) >= 0) {
    out_of_unit_box(mesh.V, box);
    if (const Status good = check(job, mesh); !good) return good.error();
    return mesh;
  }
  TetMesh result = improved(job, box, mesh);
  if (auto stop = job.context.stop()) return *stop;
  make_points_distinct(job, result);
  out_of_unit_box(result.V, box);
  Status good = check(job, result);
  if (!good && good.error().code == ErrorCode::unsolved && job.improve_degrees > 0) {
    // The quality pass is a luxury: fall back to the mesh before it.
    job.context.note(LogLevel::warning, "The quality pass broke the mesh, so the mesh before it is used: " +
                                            good.error().message);
    result = std::move(mesh);
    make_points_distinct(job, result);
    out_of_unit_box(result.V, box);
    good = check(job, result);
  }
  if (!good) return good.error();
  return result;
}

Result<TetMesh> finish_given(const FinishingJob& job, TetMesh mesh) {
  VertexMatrix V = job.input.V;
  Result<UnitBox> box = into_unit_box(V);
  if (!box) return box.error();
  back_into_unit_box(mesh.V, box.value());
  return finish(job, box.value(), std::move(mesh));
}

}  // namespace overtet
