#include "src/pipeline/strategies.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "src/cdt/tuning.h"
#include "src/immersion/immersion.h"
#include "src/pipeline/component_meshing.h"
#include "src/pipeline/flow_route.h"
#include "src/pipeline/locked_patch.h"
#include "src/pipeline/nearby_surface.h"
#include "src/pipeline/paper_route.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

// An error of a stage, which works in the unit box, in the input's space; the message names the place, too.
Error in_input_space(const MeshingJob& job, Error error) {
  if (!error.place) return error;
  VertexMatrix p(1, 3);
  p << (*error.place)[0], (*error.place)[1], (*error.place)[2];
  Index vertex = 0;
  while (vertex < job.surface.V.rows() && job.surface.V.row(vertex) != p.row(0)) ++vertex;
  out_of_unit_box(p, job.box);
  error.place = {p(0, 0), p(0, 1), p(0, 2)};
  char where[128];
  if (vertex < job.surface.V.rows())
    std::snprintf(where, sizeof where, ", near vertex %d at (%.6g, %.6g, %.6g).", vertex, p(0, 0), p(0, 1),
                  p(0, 2));
  else
    std::snprintf(where, sizeof where, ", near (%.6g, %.6g, %.6g).", p(0, 0), p(0, 1), p(0, 2));
  if (!error.message.empty() && error.message.back() == '.') error.message.pop_back();
  error.message += where;
  return error;
}

std::vector<Figure> figures_of(const ImmersionResult& x) {
  return {{"cells", std::int64_t{x.cells}},
          {"regions", std::int64_t{x.regions}},
          {"winding_max", std::int64_t{x.winding_max}},
          {"facets", std::int64_t{x.arrangement.F.rows()}},
          {"points", std::int64_t{x.arrangement.V.rows()}},
          {"rounds", std::int64_t{x.arrangement.rounds}},
          {"missing_facets", std::int64_t{x.missing_facets}},
          {"tetgen_facets", std::int64_t{x.tetgen_facets}},
          {"tetgen_parts", std::int64_t{x.tetgen_parts}},
          {"free_points", std::int64_t{x.free_points}},
          {"steiner_points", std::int64_t{x.steiner_points}},
          {"boundary_points", std::int64_t{x.boundary_points}},
          {"refined_edges", std::int64_t{x.refined_edges}},
          {"tets", std::int64_t{x.mesh.T.rows()}},
          {"arrangement_seconds", x.arrangement_seconds},
          {"tet_mesh_seconds", x.tet_mesh_seconds},
          {"sheets_seconds", x.sheets_seconds},
          {"boundary_seconds", x.boundary_seconds}};
}

// What could not be glued is kept, as the part of the surface around the place.
Error unglued(const MeshingJob& job, const Error& error) {
  if (error.place) {
    const auto& p = *error.place;
    const SubSurface patch =
        patch_around(job.surface, job.diagnosis.pairs, Eigen::Vector3d(p[0], p[1], p[2]));
    if (Status s = keep(job, "locked", patch.surface); !s) return s.error();
  }
  return in_input_space(job, error);
}

Result<Draft> mesh_immersed(const MeshingJob& job) {
  return timed_stage("immersion", job.records, job.context, [&](StageRecord& record) -> Result<Draft> {
    ImmersionOptions options;
    options.patience = job.part_without_mesh ? std::min(job.patience, kShortPatience) : job.patience;
    Result<ImmersionResult> r =
        immerse(job.surface, job.diagnosis.pairs, job.diagnosis.wound.edges, options, job.context);
    if (!r) return unglued(job, r.error());
    const ImmersionResult& x = r.value();
    if (Status s = keep(job, "arrangement", Surface{x.arrangement.V, x.arrangement.F}); !s) return s.error();
    if (Status s = keep(job, "cover", x.cover); !s) return s.error();
    record.iterations = x.search_nodes;
    record.figures = figures_of(x);
    return Draft{std::move(r.value().mesh), x.free_points};
  });
}

Result<Draft> mesh_clean(const MeshingJob& job) {
  return timed_stage("tet_mesh", job.records, job.context, [&](StageRecord& record) -> Result<Draft> {
    Result<PlainMesh> plain = mesh_plain(job.surface, job.context);
    if (!plain) return plain.error();
    PlainMesh& x = plain.value();
    record.figures = {{"missing_facets", std::int64_t{x.missing_facets}},
                      {"tetgen_facets", std::int64_t{x.tetgen_facets}},
                      {"tetgen_parts", std::int64_t{x.tetgen_parts}},
                      {"free_points", std::int64_t{x.draft.placed}},
                      {"tets", std::int64_t{x.draft.mesh.T.rows()}}};
    return std::move(x.draft);
  });
}

Result<Draft> mesh_near(const MeshingJob& job) { return without_placed(mesh_by_nearby_surface(job)); }

Result<Draft> mesh_flowed(const MeshingJob& job) {
  Result<Draft> draft = mesh_by_flow(job);
  if (!draft) return in_input_space(job, draft.error());
  return draft;
}

Result<Draft> mesh_by_recipe(const MeshingJob& job) {
  Result<TetMesh> mesh = mesh_by_paper(job);
  if (!mesh) return in_input_space(job, mesh.error());
  return without_placed(std::move(mesh));
}

const std::array all = {
    Strategy{"paper", [](const MeshingJob& job) { return job.preset == Preset::paper; }, mesh_by_recipe,
             Strategy::Failure::of_this_way},
    Strategy{"tet mesh",
             [](const MeshingJob& job) { return job.preset != Preset::paper && is_plain(job.diagnosis); },
             mesh_clean, Strategy::Failure::of_this_way},
    Strategy{"parts",
             [](const MeshingJob& job) {
               return job.preset == Preset::standard && has_parts(job.surface, job.diagnosis);
             },
             mesh_by_parts, Strategy::Failure::of_a_part},
    Strategy{"immersion", [](const MeshingJob& job) { return job.preset == Preset::standard; }, mesh_immersed,
             Strategy::Failure::of_gluing},
    Strategy{"nearby surface",
             [](const MeshingJob& job) { return job.preset == Preset::standard && may_coincide(job); },
             mesh_near, Strategy::Failure::of_this_way},
    // What flows until nothing crosses fills each part by itself: of no use where one of them has no mesh.
    Strategy{"flow",
             [](const MeshingJob& job) { return job.preset != Preset::paper && !job.part_without_mesh; },
             mesh_flowed, Strategy::Failure::of_this_way}};

}  // namespace

std::span<const Strategy> strategies() { return all; }

}  // namespace overtet
