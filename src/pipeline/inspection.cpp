#include "src/pipeline/inspection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kernels/core/assertions.h"
#include "kernels/predicates/predicates.h"
#include "src/covering/pierced_edge.h"
#include "src/exact/ordinary_size.h"
#include "src/mesh/flat_faces.h"
#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

// pre: the first face has an area.
bool lies_in_a_plane(const Surface& s) {
  const auto point = [&](Index v) { return s.V.data() + 3 * static_cast<std::ptrdiff_t>(v); };
  for (Index v = 0; v < s.V.rows(); ++v)
    if (orient3d(point(s.F(0, 0)), point(s.F(0, 1)), point(s.F(0, 2)), point(v)) != 0) return false;
  return true;
}

Error unsolved(std::string message) { return {ErrorCode::unsolved, std::move(message)}; }

// Why nothing is tried although nothing may forbid a mesh: numbers that meshes cannot be made of in doubles.
// pre: finite, indices in range.
std::optional<Error> wrong_shape(const Surface& s, UnitBox& box) {
  VertexMatrix V = s.V;
  Result<UnitBox> fits = into_unit_box(V);
  if (!fits) return fits.error();
  box = fits.value();
  if (const std::vector<Index> flat = flat_faces({V, s.F}, kRoundedHeight); !flat.empty()) {
    Error error =
        unsolved("Face " + std::to_string(flat[0]) +
                 (flat.size() > 1 ? " (and " + std::to_string(flat.size() - 1) + " more)" : std::string()) +
                 " is so thin that its area is lost in rounding, and no mesh is looked for. Move a corner or "
                 "collapse an edge.");
    error.face = flat[0];
    return error;
  }
  if (lies_in_a_plane(s))
    return unsolved("The surface is flat: all vertices lie in one plane, so there is no inside to mesh.");
  return std::nullopt;
}

}  // namespace

Result<Inspection> inspect(const Surface& surface, InspectionDepth depth, const RunContext& context) {
  Inspection r;
  const Index n = static_cast<Index>(surface.V.rows());
  const bool sane = n > 0 && surface.F.rows() > 0 && surface.V.allFinite() && surface.F.minCoeff() >= 0 &&
                    surface.F.maxCoeff() < n;
  const std::optional<Error> shape = sane ? wrong_shape(surface, r.box) : std::nullopt;
  DiagnoseOptions options;
  options.full_winding_range = depth != InspectionDepth::verdict;
  Result<Diagnosis> d = diagnose(surface, options, context);
  if (!d) return d.error();
  r.diagnosis = std::move(d).value();
  r.problem = refuse(r.diagnosis);
  if (depth == InspectionDepth::everything)
    if (Status s = look_for_conflict(surface, r, context); !s) return s.error();
  if (!r.problem) r.problem = shape;
  return r;
}

Status look_for_conflict(const Surface& surface, Inspection& r, const RunContext& context) {
  if (Status s = diagnose_further(surface, {}, r.diagnosis, context); !s) return s;
  if (!r.problem) r.problem = refuse(r.diagnosis);
  return success();
}

Result<CloseLook> look_closely(const Surface& surface, const Inspection& r, const RunContext& context) {
  OVERTET_EXPECTS(r.usable());
  const Diagnosis& d = r.diagnosis;
  const SurfaceTopology& topology = d.topology.topology;
  const OrdinarySize sized(surface, *d.bvh);
  CloseLook out;
  for (const Hinge& hinge : d.hinges) {
    if (auto stop = context.stop()) return *stop;
    out.edges.emplace_back();
    for (const Index h : half_edges_around(topology, hinge.vertex))
      out.edges.back().push_back(
          {half_edge_target(surface.F, h), edge_levels(sized.surface(), topology, sized.bvh(), h,
                                                       piercing_faces(d.pierced_edges, topology, h))});
  }
  Result<Curves> curves = trace_curves(surface, *d.bvh, *d.graph, context);
  if (!curves) return curves.error();
  out.curves = std::move(curves).value();
  return out;
}

InputRecord input_record(const Inspection& r) {
  const Diagnosis& d = r.diagnosis;
  InputRecord record;
  record.vertices = d.vertices;
  record.faces = d.faces;
  if (!d.topology.ok()) return record;
  record.components = static_cast<std::int64_t>(d.topology.topology.components.size());
  for (const SurfaceComponent& c : d.topology.topology.components) record.genus.push_back(c.genus);
  if (!r.usable()) return record;
  record.pairs = static_cast<std::int64_t>(d.pairs.size());
  record.hinges = static_cast<std::int64_t>(d.hinges.size());
  record.winding_min = d.winding.min;
  record.winding_max = d.winding.max;
  return record;
}

}  // namespace overtet
