#include "src/pipeline/pipeline.h"

#include <chrono>
#include <cmath>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "kernels/core/box.h"
#include "kernels/parallel/parallel.h"
#include "src/improve/tuning.h"
#include "src/opening/angle_bounds.h"
#include "src/opening/opening.h"
#include "src/pipeline/mesh_or_repair.h"
#include "src/pipeline/stage_clock.h"
#include "src/run/run_monitor.h"

namespace overtet {

namespace {

double seconds_since(RunContext::Clock::time_point start) {
  return std::chrono::duration<double>(RunContext::Clock::now() - start).count();
}

MovedAngles angles_at_moved(const Surface& surface, const MeshingOptions& options, const TetMesh& mesh) {
  const double diagonal = diagonal_of(surface.V);
  const AngleBounds bounds = angle_bounds(mesh, surface.F, surface.V, options.max_repair_move * diagonal);
  return {least_angle_at_moved(mesh, surface.V), bounds.at_moved, bounds.as_moved, bounds.elsewhere};
}

void hand_over(const Surface& surface, const MeshingOptions& options, const RunContext& context,
               MeshedSurface meshed, PipelineResult& result) {
  Report& report = result.report;
  report.status = meshed.moves                   ? RunStatus::repaired
                  : meshed.refined               ? RunStatus::refined
                  : !meshed.flipped_tets.empty() ? RunStatus::flipped
                  : !meshed.branch_edges.empty() ? RunStatus::branched
                                                 : RunStatus::exact;
  (void)timed_stage("measure", report.stages, context, [&](StageRecord&) -> Status {
    parallel_invoke(
        [&] {
          report.quality = tet_quality(meshed.mesh);
          if (meshed.moves) report.moved_angles = angles_at_moved(surface, options, meshed.mesh);
        },
        [&] { report.result_hash = hash_of(meshed.mesh); });
    return success();
  });
  result.mesh = std::move(meshed.mesh);
  report.branch_edges = std::move(meshed.branch_edges);
  report.flipped_tets = std::move(meshed.flipped_tets);
  if (meshed.refined) {
    report.subdivided_faces = meshed.refined->subdivided;
    report.added_vertices =
        meshed.refined->surface.V.rows() - static_cast<Eigen::Index>(report.input.vertices);
    report.face_of_piece = meshed.refined->face;
    result.refined = std::move(*meshed.refined);
  }
  // The witness says why the surface as it was read has none, which is still so.
  if (!meshed.moves) return;
  const Moves& moves = *meshed.moves;
  report.certificate.reset();
  report.moved_vertices = static_cast<std::int64_t>(moves.vertices.size());
  report.max_relative_move = moves.max_relative;
  report.mean_relative_move = moves.mean_relative;
  report.moved_ids.assign(moves.vertices.begin(), moves.vertices.end());
}

void fail(Error e, PipelineResult& result) {
  result.report.status = status_of(e.code);
  result.report.message = e.message;
  result.error = std::move(e);
}

}  // namespace

Status MeshingOptions::validate() const {
  if (!(improve_degrees >= 0 && improve_degrees <= 40))
    return Error{ErrorCode::usage, "The angle for the quality pass must lie between 0 and 40 degrees."};
  if (!(max_repair_move > 0 && max_repair_move <= 1))
    return Error{ErrorCode::usage, "The largest move must be a part of the diagonal between 0 and 1."};
  const bool refines = on_infeasible == OnInfeasible::refine || on_infeasible == OnInfeasible::branch;
  if (refines && !(save_stages.empty() && resume.empty()))
    return Error{
        ErrorCode::usage,
        "Stages are saved and resumed of the surface as it was read only: they do not go together with "
        "refining it or with branch lines."};
  if (!save_flow.empty() && preset != Preset::paper && preset != Preset::flow)
    return Error{ErrorCode::usage, "Only the presets paper and flow have a flow to save."};
  const auto good = [](double x) { return x >= 0 && std::isfinite(x); };
  if (!good(sizes.max_volume) || !good(sizes.max_edge))
    return Error{ErrorCode::usage,
                 "The largest volume and the longest edge of a tet must be positive numbers, or 0 for any."};
  for (std::size_t v = 0; v < sizes.at_vertex.size(); ++v)
    if (!(sizes.at_vertex[v] > 0))
      return Error{ErrorCode::usage, "The size at vertex " + std::to_string(v) +
                                         " (counted from 0) must be a positive number, or infinite for any."};
  if (!(recipe.delta > 0 && recipe.delta <= 1))
    return Error{ErrorCode::usage, "The time step of the forward flow must lie between 0 and 1."};
  if (!(recipe.repulsion >= 0 && recipe.repulsion <= 1e9))
    return Error{ErrorCode::usage, "The weight of the repulsion must lie between 0 and 1e9."};
  if (!(recipe.radius_edge >= 1.1 && recipe.radius_edge <= 100))
    return Error{ErrorCode::usage, "The radius-edge bound must lie between 1.1 and 100."};
  if (recipe.remesh_every < 0)
    return Error{ErrorCode::usage, "The iterations between two remeshings must not be negative."};
  if ((allow_branches || allow_flips) && (preset != Preset::paper || on_infeasible != OnInfeasible::reject))
    return Error{
        ErrorCode::usage,
        "Only the paper's recipe makes flipped tets or branch lines that can be allowed, and only of the "
        "surface as it was read."};
  if (improve_degrees == 0 && (sizes.any() || sizes.coarse))
    return Error{ErrorCode::usage,
                 "Sizes are made by the quality pass; do not leave it out (its angle must not be 0)."};
  return success();
}

PipelineResult run_pipeline(const Surface& surface, const MeshingOptions& options, const RunContext& outer) {
  PipelineResult result;
  const auto start = RunContext::Clock::now();
  if (Status s = options.validate(); !s) {
    fail(s.error(), result);
    return result;
  }
  if (const auto given = options.sizes.at_vertex.size();
      given > 0 && given != static_cast<std::size_t>(surface.V.rows())) {
    fail({ErrorCode::usage, "There are " + std::to_string(given) + " sizes for " +
                                std::to_string(surface.V.rows()) +
                                " vertices of the surface; give one for each, in their order."},
         result);
    return result;
  }
  // Tets and what is at their corners are numbered with 32 bits, and meshes have some three tets a face.
  if (const auto most = static_cast<Eigen::Index>(kMostTets / 4); surface.F.rows() > most) {
    fail({ErrorCode::limit, "The surface has " + std::to_string(surface.F.rows()) + " faces; at most " +
                                std::to_string(most) +
                                " can be meshed at once. Mesh it in parts, or decimate it."},
         result);
    return result;
  }
  RunMonitor watch(outer);
  try {
    const ScopedThreads threads(outer.threads);
    Result<MeshedSurface> meshed = mesh_or_repair(surface, options, watch.context(), result.report);
    if (meshed)
      hand_over(surface, options, watch.context(), std::move(meshed).value(), result);
    else
      fail(watch.explained(meshed.error()), result);
  } catch (const std::exception&) {
    result.mesh = {};
    fail(watch.explained(error_of_exception()), result);
  }
  result.report.seconds = seconds_since(start);
  result.report.peak_rss_bytes = watch.peak_bytes();
  return result;
}

}  // namespace overtet
