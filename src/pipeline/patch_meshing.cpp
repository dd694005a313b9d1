#include "src/pipeline/patch_meshing.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/tuning.h"
#include "overtet/verification.h"
#include "src/immersion/immersion.h"
#include "src/pipeline/component_meshing.h"
#include "src/pipeline/solid_patch.h"
#include "src/pipeline/stage_clock.h"

namespace overtet {

namespace {

// The patch as any surface: without crossings, component by component, or by the immersion.
Result<Draft> mesh_closed(const MeshingJob& job, const Surface& surface) {
  DiagnoseOptions options;
  options.full_winding_range = false;
  Result<Diagnosis> d = diagnose(surface, options, job.context);
  if (!d) return d.error();
  if (auto refused = refuse(d.value())) return Error{ErrorCode::unsolved, refused->message, refused->place};
  if (is_plain(d.value())) {
    Result<PlainMesh> plain = mesh_plain(surface, job.context);
    if (!plain) return plain.error();
    return std::move(plain.value().draft);
  }
  if (has_parts(surface, d.value())) {
    std::vector<StageRecord> records;  // of this stage, which has one record
    Result<Draft> parts = mesh_by_parts({surface, job.box, d.value(), job.context, records});
    if (parts || ends_run(parts.error())) return parts;
  }
  Result<ImmersionResult> r = immerse(surface, d.value().pairs, d.value().wound.edges, {}, job.context);
  if (!r) return r.error();
  return Draft{std::move(r.value().mesh), r.value().free_points};
}

Status check(const MeshingJob& job, const TetMesh& mesh) {
  const VerifyResult v = verify(job.surface, mesh, {}, job.context);
  if (!v.complete) return job.context.stop().value_or(Error{ErrorCode::interrupted, "Interrupted."});
  if (v.ok()) return success();
  return Error{ErrorCode::unsolved, "The glued mesh is wrong: " + v.summary()};
}

std::vector<Index> not_home(const TetMesh& mesh, const VertexMatrix& target) {
  std::vector<Index> away;
  for (Index v = 0; v < mesh.surface_vertices; ++v)
    if (mesh.V.row(v) != target.row(v)) away.push_back(v);
  return away;
}

}  // namespace

Result<Draft> mesh_by_patch(const MeshingJob& job, const TetMesh& embedded) {
  return timed_stage("patch", job.records, job.context, [&](StageRecord& record) -> Result<Draft> {
    const std::vector<Index> away = not_home(embedded, job.surface.V);
    if (away.empty())
      return Draft{embedded, static_cast<Index>(embedded.V.rows()) - embedded.surface_vertices};
    Error last{ErrorCode::unsolved, "No patch was tried."};
    std::size_t tried = 0;  // tets of the last patch
    for (int rings = 1; rings <= kRings; ++rings) {
      if (auto stop = job.context.stop()) return *stop;
      const SolidPatch patch = solid_around(embedded, job.surface.V, away, rings);
      if (static_cast<Eigen::Index>(patch.tets.size()) == embedded.T.rows()) {
        if (rings == 1)
          last = {ErrorCode::unsolved,
                  "Nearly everything has moved, so that the patch would be all of the mesh."};
        break;
      }
      if (patch.tets.size() == tried) continue;  // what was pinched had made it as wide before
      tried = patch.tets.size();
      record.iterations = rings;
      record.figures = {
          {"away", static_cast<std::int64_t>(away.size())},
          {"patch_faces", static_cast<std::int64_t>(patch.target.F.rows())},
          {"patch_tets", static_cast<std::int64_t>(tried)},
          {"kept_tets", static_cast<std::int64_t>(embedded.T.rows()) - static_cast<std::int64_t>(tried)}};
      if (Status s = keep(job, "patch", patch.target); !s) return s.error();
      Result<Draft> inside = mesh_closed(job, patch.target);
      if (inside) {
        Draft whole = glued(embedded, job.surface.V, patch, inside.value());
        const Status right = check(job, whole.mesh);
        if (right) {
          record.figures.emplace_back("tets", static_cast<std::int64_t>(whole.mesh.T.rows()));
          return whole;
        }
        last = right.error();
      } else {
        last = inside.error();
      }
      if (ends_run(last)) return last;
    }
    return Error{ErrorCode::unsolved, last.message, last.place};
  });
}

}  // namespace overtet
