#include "src/pipeline/inspection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "kernels/predicates/predicates.h"
#include "src/covering/gluing.h"
#include "src/covering/pierced_edge.h"
#include "src/exact/ordinary_size.h"

namespace overtet {

namespace {

std::string shortest(double x) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, x).ptr};
}

// Faces whose height is within the rounding of their own coordinates. They may have an area in exact
// arithmetic, of either sign; nobody can have meant it, and no tet of any use stands on them.
std::vector<Index> flat_up_to_rounding(const Surface& s) {
  constexpr double kUlps = 4 * 0x1p-53;
  std::vector<Index> flat;
  for (Index f = 0; f < s.F.rows(); ++f) {
    const Eigen::Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
    const double longest =
        std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
    const double reach =
        std::max({a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff(), c.cwiseAbs().maxCoeff()});
    if ((b - a).cross(c - a).norm() <= kUlps * reach * longest) flat.push_back(f);
  }
  return flat;
}

// pre: the first face has an area.
bool lies_in_a_plane(const Surface& s) {
  const auto point = [&](Index v) { return s.V.data() + 3 * static_cast<std::ptrdiff_t>(v); };
  for (Index v = 0; v < s.V.rows(); ++v)
    if (orient3d(point(s.F(0, 0)), point(s.F(0, 1)), point(s.F(0, 2)), point(v)) != 0) return false;
  return true;
}

Error bad_input(std::string message) { return {ErrorCode::bad_input, std::move(message)}; }

// What is wrong with the numbers of a surface, whatever its topology. pre: finite, indices in range.
std::optional<Error> wrong_shape(const Surface& s, UnitBox& box) {
  VertexMatrix V = s.V;
  Result<UnitBox> fits = into_unit_box(V);
  if (!fits) return fits.error();
  box = fits.value();
  if (const std::vector<Index> flat = flat_up_to_rounding({V, s.F}); !flat.empty())
    return bad_input(
        "Face " + std::to_string(flat[0]) +
        (flat.size() > 1 ? " (and " + std::to_string(flat.size() - 1) + " more)" : std::string()) +
        " has no area up to the rounding of its corners: no tet with a volume can have it as a face.");
  if (lies_in_a_plane(s))
    return bad_input("The surface is flat: all vertices lie in one plane, so there is no inside to mesh.");
  return std::nullopt;
}

std::optional<WitnessRecord> witness_of(const Surface& surface, const Diagnosis& d) {
  WitnessRecord record;
  const auto add = [&](Index v, int B0) {
    record.vertices.push_back(v);
    record.B0.push_back(B0);
    record.positions.push_back({surface.V(v, 0), surface.V(v, 1), surface.V(v, 2)});
  };
  if (const auto& w = d.winding.witness) {
    record.rule = WitnessRecord::Rule::winding;
    record.winding = w->winding;
    record.point = w->exact;
    if (w->doubles_suffice)
      for (std::size_t k = 0; k < 3; ++k) record.point[k] = shortest(w->point[k]);
    return record;
  }
  if (d.vertex_witness) {
    record.rule = WitnessRecord::Rule::vertex;
    add(d.vertex_witness->vertex, d.vertex_witness->B0);
    return record;
  }
  if (d.fold_witness) {
    record.rule = WitnessRecord::Rule::fold;
    add(d.fold_witness->vertex, d.fold_witness->B0);
    return record;
  }
  if (d.stack) {
    record.rule = WitnessRecord::Rule::stack;
    record.face = d.stack->face;
    record.point = d.stack->exact;
    record.vertices = d.stack->vertices;
    record.moves = d.stack->moves;
    record.winding = d.stack->winding;
    record.positions.push_back(d.stack->point);
    return record;
  }
  if (!d.wound.odd_groups.empty()) {
    record.rule = WitnessRecord::Rule::unpaired;
    const auto& group = d.wound.odd_groups.front();
    if (d.wound.apart) {
      record.apart = d.wound.apart->direction;
      for (std::size_t i = 0; i < group.size(); ++i) add(group[i], d.wound.apart->B0[i]);
      return record;
    }
    for (const Hinge& h : d.hinges)
      if (std::binary_search(group.begin(), group.end(), h.vertex)) add(h.vertex, h.B0.value_or(0));
    return record;
  }
  if (d.wound.shared) {
    record.rule = WitnessRecord::Rule::shared;
    record.vertices = d.wound.shared->vertices;
    record.layers = d.wound.shared->layers;
    record.room = d.wound.shared->room;
    for (const Index v : record.vertices)
      record.positions.push_back({surface.V(v, 0), surface.V(v, 1), surface.V(v, 2)});
    return record;
  }
  const bool crowded = !d.wound.crowded.empty();
  const std::vector<Index>& named = crowded ? d.wound.crowded : d.wound.unfillable;
  if (named.empty()) return std::nullopt;
  record.rule = crowded ? WitnessRecord::Rule::crowded : WitnessRecord::Rule::link;
  for (const Hinge& h : d.hinges)
    if (h.vertex == named.front()) add(h.vertex, h.B0.value_or(0));
  return record;
}

}  // namespace

Result<Inspection> inspect(const Surface& surface, InspectionDepth depth, const RunContext& context) {
  Inspection r;
  const Index n = static_cast<Index>(surface.V.rows());
  const bool sane = n > 0 && surface.F.rows() > 0 && surface.V.allFinite() && surface.F.minCoeff() >= 0 &&
                    surface.F.maxCoeff() < n;
  // First: exact decisions are slow on numbers that nothing can be made of.
  std::optional<Error> shape;
  if (sane) shape = wrong_shape(surface, r.box);
  if (shape) {
    r.diagnosis.vertices = n;
    r.diagnosis.faces = static_cast<Index>(surface.F.rows());
    r.diagnosis.topology = check_topology(surface);
    r.diagnosis.message = shape->message;
    r.problem = r.diagnosis.topology.ok() ? *shape : bad_input(r.diagnosis.topology.problems.front());
    return r;
  }
  DiagnoseOptions options;
  options.full_winding_range = depth == InspectionDepth::everything;
  Result<Diagnosis> d = diagnose(surface, options, context);
  if (!d) return d.error();
  r.diagnosis = std::move(d).value();
  r.problem = refuse(r.diagnosis);
  if (r.problem && r.problem->code == ErrorCode::infeasible) r.witness = witness_of(surface, r.diagnosis);
  if (depth == InspectionDepth::everything)
    if (Status s = look_for_conflict(surface, r, context); !s) return s.error();
  return r;
}

Status look_for_conflict(const Surface& surface, Inspection& r, const RunContext& context) {
  Diagnosis& d = r.diagnosis;
  if (r.problem || d.verdict != Verdict::feasible) return success();
  const Result<GluingAnswer> answer = check_gluing(surface, d.topology.topology, *d.bvh, *d.graph, context);
  if (!answer) return answer.error();
  const GluingAnswer& a = answer.value();
  if (a.verdict != GluingVerdict::conflict) return success();
  WitnessRecord record;
  record.rule = WitnessRecord::Rule::gluing;
  for (const auto& c : a.crossings) {
    record.pairs.push_back({c.faces.first, c.faces.second});
    record.layers.push_back(c.layers);
    record.positions.push_back(c.place);
  }
  record.edges = a.edges;
  r.witness = std::move(record);
  d.verdict = Verdict::obstructed;
  d.message = a.message;
  r.problem = Error{ErrorCode::infeasible, a.message};
  if (!a.crossings.empty()) r.problem->place = a.crossings[0].place;
  return success();
}

Result<CloseLook> look_closely(const Surface& surface, const Inspection& r, const RunContext& context) {
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
