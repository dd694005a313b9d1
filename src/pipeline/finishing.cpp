#include "src/pipeline/finishing.h"

#include <algorithm>
#include <utility>

#include "overtet/verification.h"
#include "src/improve/improve.h"
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
      {"refined_vertices", x.refined},
      {"removed_edges", all.removed_edges},
      {"flips", all.flips},
      {"smoothed", all.smoothed},
      {"contracted_edges", all.collapsed},
      {"inserted_vertices", all.inserted},
      {"lifted", std::int64_t{x.lifted}},
      {"traded", x.traded},
      {"parts", std::int64_t{x.rounds.empty() ? 0 : *std::max_element(x.rounds.begin(), x.rounds.end())}},
      {"tets", std::int64_t{mesh.T.rows()}}};
}

// The mesh after the quality pass; the mesh itself when the pass cannot be made.
TetMesh improved(const FinishingJob& job, const TetMesh& mesh) {
  if (job.improve_degrees <= 0) return mesh;
  TetMesh better = mesh;
  const Status done = timed_stage("improve", job.records, job.context, [&](StageRecord& record) -> Status {
    ImproveOptions options;
    options.target_degrees = job.improve_degrees;
    Result<ImproveResult> r = improve(better, options, job.context);
    if (!r) return r.error();
    if (r.value().end == ImproveResult::End::time_over)
      job.context.note(LogLevel::warning, "The quality pass ended early because of the time limit.");
    write_down(r.value(), better, record);
    return success();
  });
  return done ? better : mesh;
}

Status check(const FinishingJob& job, const TetMesh& mesh) {
  return timed_stage("verify", job.records, job.context, [&](StageRecord& record) -> Status {
    VerifyOptions options;
    options.allow_branches = job.allow_branches;
    const VerifyResult v = verify(job.input, mesh, options, job.context);
    if (!v.complete) return job.context.stop().value_or(Error{ErrorCode::interrupted, "Interrupted."});
    record.figures.emplace_back("tets", v.tets);
    if (!v.ok()) return Error{ErrorCode::unsolved, "The tet mesh that was found is wrong: " + v.summary()};
    return success();
  });
}

}  // namespace

Result<TetMesh> finish(const FinishingJob& job, const UnitBox& box, TetMesh mesh) {
  TetMesh result = improved(job, mesh);
  if (auto stop = job.context.stop()) return *stop;
  out_of_unit_box(result.V, box);
  Status good = check(job, result);
  if (!good && good.error().code == ErrorCode::unsolved && job.improve_degrees > 0) {
    // The quality pass is a luxury: fall back to the mesh before it.
    job.context.note(LogLevel::warning, "The quality pass broke the mesh, so the mesh before it is used: " +
                                            good.error().message);
    result = std::move(mesh);
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
