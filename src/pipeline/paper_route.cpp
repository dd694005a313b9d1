#include "src/pipeline/paper_route.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "overtet/verification.h"
#include "src/mesh/tet_complex.h"
#include "src/pipeline/component_meshing.h"
#include "src/pipeline/flow_stages.h"
#include "src/pipeline/stage_clock.h"

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

Result<TetMesh> map_home(const MeshingJob& job, const TetMesh& mesh) {
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

// One part of the surface, all of it free to move.
Result<TetMesh> mesh_part(const MeshingJob& job) {
  Result<ForwardFlowResult> forward = flow_forward(job, forward_options(job.recipe));
  if (!forward) return in_piece("Forward flow", forward.error());
  if (Status s = keep(job, "flow_end", Surface{forward.value().V, job.surface.F}); !s) return s.error();
  Result<ReverseFlowResult> back = flow_back(job, forward.value(), reverse_options(job.recipe));
  if (!back) return in_piece("Reverse flow", back.error());
  const VertexMatrix& U0 = back.value().U0;
  if (Status s = keep(job, "embedded", Surface{U0, job.surface.F}); !s) return s.error();
  TetMeshOptions options;
  options.radius_edge = job.recipe.radius_edge;
  Result<TetMesh> filled = fill(job, U0, options);
  if (!filled) return in_piece("Tet mesh", filled.error());
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
    own.allowed = job.allowed;
    Result<TetMesh> mesh = mesh_part(own);
    if (!mesh) return mesh;
    meshes.push_back({parts[p].vertices, std::move(mesh).value()});
  }
  return std::move(united(job.surface.V, meshes).mesh);
}

}  // namespace overtet
