#include "src/pipeline/paper_route.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "overtet/verification.h"
#include "src/lim/lim.h"
#include "src/mesh/tet_complex.h"
#include "src/pipeline/component_meshing.h"
#include "src/pipeline/flow_stages.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/tuning.h"
#include "src/volume_arap/volume_arap.h"

namespace overtet {

namespace {

ForwardFlowOptions forward_options(const PaperRecipe& recipe) {
  if (recipe.forward == PaperRecipe::Forward::regional) {
    ForwardFlowOptions o = forward_flow_ladder().front();
    o.global.clear();
    return o;
  }
  ForwardFlowOptions o = paper_forward_flow();
  for (GlobalFlow& way : o.global) way.delta = recipe.delta;
  return o;
}

ReverseFlowOptions reverse_options(const PaperRecipe& recipe) {
  if (recipe.reverse == PaperRecipe::Reverse::barrier) return reverse_flow_ladder().front();
  ReverseFlowOptions o = paper_reverse_flow();
  o.repulsion = recipe.repulsion;
  return o;
}

Error in_piece(const char* piece, Error e) {
  if (!ends_run(e)) e = {ErrorCode::unsolved, std::string(piece) + ": " + e.message, e.place};
  return e;
}

std::string counted(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

Result<TetMesh> map_by_arap(const MeshingJob& job, const TetMesh& mesh) {
  return timed_stage("volume_arap", job.records, job.context, [&](StageRecord& record) -> Result<TetMesh> {
    Result<VolumeArapResult> mapped = volume_arap(mesh, job.surface.V, {}, job.context);
    if (!mapped) return mapped.error();
    VolumeArapResult& x = mapped.value();
    record.iterations = x.iterations;
    record.figures = {{"tets", std::int64_t{x.mesh.T.rows()}},
                      {"flipped", static_cast<std::int64_t>(x.flipped.size())},
                      {"energy", x.energy}};
    if (Status s = keep(job, "arap", x.mesh); !s) return s.error();
    if (!x.flipped.empty() && !job.allowed.flips)
      return Error{ErrorCode::unsolved, counted(x.flipped.size(), "tet is", "tets are") + " flipped, of " +
                                            std::to_string(x.mesh.T.rows()) + ", so the mesh is not exact."};
    return std::move(x.mesh);
  });
}

const char* name_of(LimResult::End end) {
  switch (end) {
    case LimResult::End::reached:
      return "reached";
    case LimResult::End::stalled:
      return "stalled";
    case LimResult::End::iterations:
      return "iterations";
    case LimResult::End::time:
      return "time";
  }
  return "";
}

Result<TetMesh> map_by_lim(const MeshingJob& job, const TetMesh& mesh) {
  return timed_stage("lim", job.records, job.context, [&](StageRecord& record) -> Result<TetMesh> {
    LimOptions options;
    options.radius_edge = job.recipe.radius_edge;
    options.remesh_every = job.recipe.remesh_every;
    options.seconds = std::min(options.seconds, kMapTime * job.context.seconds_left());
    Result<LimResult> mapped = lim(mesh, job.surface.V, options, job.context);
    if (!mapped) return mapped.error();
    LimResult& x = mapped.value();
    record.iterations = static_cast<std::int64_t>(x.iterations.size());
    record.figures = {{"tets", std::int64_t{x.mesh.T.rows()}},
                      {"end", std::string(name_of(x.end))},
                      {"away", static_cast<std::int64_t>(x.away.size())},
                      {"jumped", x.jumped},
                      {"remeshes", static_cast<std::int64_t>(x.remeshes.size())}};
    if (!x.iterations.empty()) record.figures.emplace_back("distance", x.iterations.back().distance);
    if (Status s = keep(job, "lim", x.mesh); !s) return s.error();
    if (x.end == LimResult::End::reached) return std::move(x.mesh);
    Index farthest = x.away.empty() ? 0 : x.away[0];
    const auto distance = [&](Index v) { return (x.mesh.V.row(v) - job.surface.V.row(v)).squaredNorm(); };
    for (const Index v : x.away)
      if (distance(v) > distance(farthest)) farthest = v;
    const auto place = job.surface.V.row(farthest);
    return Error{ErrorCode::unsolved,
                 "The map locks with " + counted(x.away.size(), "boundary vertex", "boundary vertices") +
                     " away from home, of " + std::to_string(job.surface.V.rows()) +
                     ", every tet positive; the farthest lies here.",
                 std::array<double, 3>{place[0], place[1], place[2]}};
  });
}

Result<TetMesh> map_home(const MeshingJob& job, const TetMesh& mesh) {
  if (job.recipe.map == PaperRecipe::Map::lim) {
    Result<TetMesh> mapped = map_by_lim(job, mesh);
    return mapped ? std::move(mapped) : in_piece("Locally injective map", mapped.error());
  }
  if (job.recipe.map == PaperRecipe::Map::arap) {
    Result<TetMesh> mapped = map_by_arap(job, mesh);
    return mapped ? std::move(mapped) : in_piece("Volumetric ARAP", mapped.error());
  }
  Result<TetMesh> mapped = map(job, mesh, MapCare::usual);
  if (!mapped) return in_piece("Volume map", mapped.error());
  return mapped;
}

// What the map made, counted: how many interior edges have two turns or more.
Status count_turns(const MeshingJob& job, const TetMesh& mesh) {
  return timed_stage("turns", job.records, job.context, [&](StageRecord& record) -> Status {
    VerifyOptions options;
    options.allow_branches = true;
    const VerifyResult v = verify(job.surface, mesh, options, job.context);
    if (!v.complete) return job.context.stop().value_or(Error{ErrorCode::interrupted, "Interrupted."});
    const auto count = static_cast<std::int64_t>(v.branch_edges.size());
    record.figures = {{"tets", v.tets}, {"branch_edges", count}};
    if (!v.ok()) return Error{ErrorCode::unsolved, "The tet mesh is wrong: " + v.summary()};
    if (count == 0 || job.allowed.branches || job.allowed.flips) return success();
    return Error{ErrorCode::unsolved, "Every tet is positive, but around " + std::to_string(count) +
                                          " interior edges (of " + std::to_string(v.tets) +
                                          " tets) they make two turns or more, so the mesh is not exact."};
  });
}

Result<TetMesh> embedded_and_filled(const MeshingJob& job) {
  TetMeshOptions options;
  options.radius_edge = job.recipe.radius_edge;
  if (auto saved = saved_fill(job, options)) return *std::move(saved);
  Result<ForwardFlowResult> forward = flow_forward(job, forward_options(job.recipe));
  if (!forward) return in_piece("Forward flow", forward.error());
  if (Status s = keep(job, "flow_end", Surface{forward.value().V, job.surface.F}); !s) return s.error();
  Result<ReverseFlowResult> back = flow_back(job, forward.value(), reverse_options(job.recipe));
  if (!back) return in_piece("Reverse flow", back.error());
  const VertexMatrix& U0 = back.value().U0;
  if (Status s = keep(job, "embedded", Surface{U0, job.surface.F}); !s) return s.error();
  Result<TetMesh> filled = fill(job, U0, options);
  if (!filled) return in_piece("Tet mesh", filled.error());
  return filled;
}

// One part of the surface, all of it free to move.
Result<TetMesh> mesh_part(const MeshingJob& job) {
  Result<TetMesh> filled = embedded_and_filled(job);
  if (!filled) return filled;
  Result<TetMesh> mapped = map_home(job, filled.value());
  if (!mapped) return mapped;
  if (first_not_positive(mapped.value()) < 0)
    if (Status s = count_turns(job, mapped.value()); !s) return s.error();
  return mapped;
}

// What is known of the whole, of each of its parts.
std::vector<Diagnosis> of_parts(const MeshingJob& job, const std::vector<SubSurface>& parts) {
  struct Place {
    Index part = -1, number = -1;
  };
  std::vector<Place> vertex(static_cast<std::size_t>(job.surface.V.rows())),
      face(static_cast<std::size_t>(job.surface.F.rows()));
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const auto note = [&](const std::vector<Index>& numbers, std::vector<Place>& places) {
      for (std::size_t i = 0; i < numbers.size(); ++i)
        places[numbers[i]] = {static_cast<Index>(p), static_cast<Index>(i)};
    };
    note(parts[p].vertices, vertex);
    note(parts[p].faces, face);
  }
  std::vector<Diagnosis> known(parts.size());
  for (const auto& [f, g] : job.diagnosis.pairs)
    if (face[f].part >= 0 && face[f].part == face[g].part)
      known[face[f].part].pairs.push_back({face[f].number, face[g].number});
  for (WoundEdge w : job.diagnosis.wound.edges) {
    const Index part = vertex[w.a].part;
    if (part < 0) continue;
    w.a = vertex[w.a].number, w.b = vertex[w.b].number;
    known[part].wound.edges.push_back(w);
  }
  return known;
}

}  // namespace

Result<TetMesh> mesh_by_paper(const MeshingJob& job) {
  const std::vector<SubSurface> parts = parts_of(job.surface, job.diagnosis);
  if (parts.empty()) return mesh_part(job);
  const std::vector<Diagnosis> known = of_parts(job, parts);
  std::vector<PartMesh> meshes;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    MeshingJob own{parts[p].surface, job.box, known[p], job.context, job.records};
    own.recipe = job.recipe;
    own.film = job.film;
    own.allowed = job.allowed;
    Result<TetMesh> mesh = mesh_part(own);
    if (!mesh) return mesh;
    meshes.push_back({parts[p].vertices, std::move(mesh).value()});
  }
  return std::move(united(job.surface.V, meshes).mesh);
}

}  // namespace overtet
