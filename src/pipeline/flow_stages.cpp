#include "src/pipeline/flow_stages.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "kernels/bvh/self_intersections.h"
#include "kernels/core/tuning.h"
#include "overtet/verification.h"
#include "src/pipeline/solid_patch.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

void say_cut(const MeshingJob& r, const char* stage) {
  r.context.note(LogLevel::warning, std::string(stage) +
                                        " ended early because of the time limit; "
                                        "with more time the result may differ.");
}

Error damaged(const char* name) {
  return {ErrorCode::bad_input, std::string("The saved stage ") + name +
                                    " is damaged: it does not fit the input. Do not resume from it."};
}

// The forward flow as the first frames of a film, which the reverse flow goes on with.
Status film(const MeshingJob& r, const ForwardFlowResult& flow) {
  if (!r.film) return success();
  r.film->begin();
  const TriangleMatrix& F = r.surface.F;
  if (Status s = r.film->add(r.surface.V, F); !s) return s;
  for (std::size_t i = 0; i < flow.states.size(); ++i)
    if (Status s = r.film->add(flow.state(r.surface.V, i), F); !s) return s;
  if (Status s = r.film->add(flow.V, F); !s) return s;
  return r.film->write_list();
}

}  // namespace

Result<ForwardFlowResult> flow_forward(const MeshingJob& r, const ForwardFlowOptions& options) {
  return timed_stage("forward_flow", r.records, r.context,
                     [&](StageRecord& record) -> Result<ForwardFlowResult> {
                       std::vector<std::array<Index, 2>> pairs;
                       for (const auto& [f, g] : r.diagnosis.pairs) pairs.push_back({f, g});
                       Result<ForwardFlowResult> flowed = forward_flow(r.surface, pairs, options, r.context);
                       if (!flowed) return flowed;
                       const ForwardFlowResult& x = flowed.value();
                       if (Status s = film(r, x); !s) return s.error();
                       record.iterations = static_cast<std::int64_t>(x.steps.size());
                       const FlowQuality quality = measure_quality(x.V, r.surface.V, r.surface.F);
                       record.figures = {{"attempts", std::int64_t{x.attempts}},
                                         {"area_p01", quality.area_p01},
                                         {"area_p50", quality.area_p50},
                                         {"area_p99", quality.area_p99},
                                         {"clusters", std::int64_t{x.clusters}},
                                         {"frozen_area", x.frozen_area},
                                         {"weights", std::string(to_string(x.weights))}};
                       return flowed;
                     });
}

Result<ReverseFlowResult> flow_back(const MeshingJob& r, const ForwardFlowResult& forward,
                                    ReverseFlowOptions options) {
  return timed_stage(
      "reverse_flow", r.records, r.context, [&](StageRecord& record) -> Result<ReverseFlowResult> {
        std::vector<VertexMatrix> stages;
        if (options.staged)
          for (std::size_t i = 0; i < forward.states.size(); ++i)
            stages.push_back(forward.state(r.surface.V, i));
        if (options.response == ReverseFlowOptions::ContactResponse::barrier)
          options.max_work = kReverseWork + kReverseWorkOfFace * static_cast<double>(r.surface.F.rows());
        options.max_seconds = std::min(options.max_seconds, kHalfTime * r.context.seconds_left());
        Status filmed = success();
        if (r.film)
          options.on_state = [&](const VertexMatrix& U) {
            if (filmed) filmed = r.film->add(U, r.surface.F);
          };
        Result<ReverseFlowResult> back =
            reverse_flow(r.surface, forward.V, stages, forward.reverse_free, options, r.context);
        if (filmed && r.film && back) filmed = r.film->add(back.value().U0, r.surface.F);
        if (filmed && r.film) filmed = r.film->write_list();
        if (!back) return back;
        if (!filmed) return filmed.error();
        const ReverseFlowResult& x = back.value();
        if (x.termination == ReverseFlowResult::Termination::time) say_cut(r, "The reverse flow");
        record.iterations = x.iterations;
        record.figures = {{"locked", x.locked},
                          {"rollbacks", std::int64_t{x.rollbacks}},
                          {"area_p01", x.quality.area_p01},
                          {"area_p50", x.quality.area_p50},
                          {"area_p99", x.quality.area_p99},
                          {"edge_p01", x.quality.edge_p01},
                          {"edge_p50", x.quality.edge_p50},
                          {"edge_p99", x.quality.edge_p99},
                          {"area_within_20", x.quality.area_within_20}};
        return back;
      });
}

Result<TetMesh> fill(const MeshingJob& r, const VertexMatrix& U0, const TetMeshOptions& options) {
  Result<TetMesh> mesh =
      timed_stage("tet_mesh", r.records, r.context, [&](StageRecord& record) -> Result<TetMesh> {
        Result<TetMeshResult> filled = tet_mesh({U0, r.surface.F}, options, r.context);
        if (!filled) return filled.error();
        record.figures = {{"tets", std::int64_t{filled.value().mesh.T.rows()}},
                          {"edges_split", std::int64_t{filled.value().edges_split}},
                          {"faces_split", std::int64_t{filled.value().faces_split}},
                          {"tets_split", std::int64_t{filled.value().tets_split}}};
        return std::move(filled.value().mesh);
      });
  if (!mesh) return mesh;
  if (Status s = keep(r, "tet_mesh", mesh.value()); !s) return s.error();
  return mesh;
}

Result<TetMesh> map(const MeshingJob& r, const TetMesh& mesh, MapCare care) {
  Status kept = success();
  Result<TetMesh> mapped =
      timed_stage("volume_map", r.records, r.context, [&](StageRecord& record) -> Result<TetMesh> {
        VolumeMapOptions options;
        if (care == MapCare::careful) {
          options.interior_rings = 6;
          options.pull_growth = 1.6;
          options.rounds = 140;
          options.refinements = 8;
        }
        if (r.save)
          options.on_locked = [&](const TetMesh& state, const std::vector<Index>& away) {
            const SolidPatch patch = solid_around(state, r.surface.V, away, kRings);
            kept = r.save->save_problem("locked", patch.target, patch.start);
          };
        options.seconds = std::min(options.seconds, kMapTime * r.context.seconds_left());
        Result<VolumeMapResult> mapped =
            volume_map(mesh, r.surface.V, r.diagnosis.wound.edges, options, r.context);
        if (!mapped) return mapped.error();
        const VolumeMapResult& x = mapped.value();
        if (x.cut_by_time) say_cut(r, "The volume map");
        record.iterations = static_cast<std::int64_t>(x.rounds.size());
        record.figures = {{"tets", std::int64_t{x.mesh.T.rows()}},
                          {"away_at_start", std::int64_t{x.away_at_start}},
                          {"refinements", std::int64_t{x.refinements}},
                          {"newton_steps", x.newton_steps}};
        return std::move(mapped.value().mesh);
      });
  if (!kept) return kept.error();
  return mapped;
}

std::optional<Result<TetMesh>> saved_fill(const MeshingJob& r, const TetMeshOptions& options) {
  if (!r.resume) return std::nullopt;
  const auto surface_vertices = static_cast<Index>(r.surface.V.rows());
  if (r.resume->has("tet_mesh") && r.resume->has("embedded")) {
    Result<Surface> embedded = r.resume->load_surface("embedded");
    if (!embedded) return embedded.error();
    Result<TetMesh> mesh = r.resume->load_mesh("tet_mesh", surface_vertices);
    if (!mesh) return mesh.error();
    if (embedded.value().F != r.surface.F || !verify(embedded.value(), mesh.value(), {}, r.context).ok())
      return damaged("tet_mesh");
    return mesh;
  }
  if (r.resume->has("embedded")) {
    Result<Surface> embedded = r.resume->load_surface("embedded");
    if (!embedded) return embedded.error();
    const Surface& s = embedded.value();
    if (s.V.rows() != r.surface.V.rows() || s.F != r.surface.F || !all_finite(s.V) ||
        !find_self_intersections(s.V, s.F).empty())
      return damaged("embedded");
    return fill(r, s.V, options);
  }
  return std::nullopt;
}

}  // namespace overtet
