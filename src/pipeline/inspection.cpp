#include "src/pipeline/inspection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "kernels/bvh/self_intersections.h"
#include "kernels/predicates/predicates.h"

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

std::vector<bool> inward_components(const Surface& s, const SurfaceTopology& topology) {
  std::vector<double> volume(topology.components.size(), 0);
  std::vector<Eigen::Vector3d> origin;
  for (const SurfaceComponent& c : topology.components) origin.push_back(s.V.row(s.F(c.first_face, 0)));
  for (Index f = 0; f < s.F.rows(); ++f) {
    const auto c = static_cast<std::size_t>(topology.component_of_face[static_cast<std::size_t>(f)]);
    const Eigen::Vector3d p = s.V.row(s.F(f, 0)).transpose() - origin[c],
                          q = s.V.row(s.F(f, 1)).transpose() - origin[c],
                          r = s.V.row(s.F(f, 2)).transpose() - origin[c];
    volume[c] += p.dot(q.cross(r));
  }
  std::vector<bool> inward;
  for (const double v : volume) inward.push_back(v < 0);
  return inward;
}

Error bad_input(std::string message) { return {ErrorCode::bad_input, std::move(message)}; }

void look_for_witness(Inspection& r) {
  if (const auto& w = r.winding.witness) {
    WitnessRecord& record = r.witness.emplace();
    record.winding = w->winding;
    record.point = w->exact;
    if (w->doubles_suffice)
      for (std::size_t k = 0; k < 3; ++k) (*record.point)[k] = shortest(w->point[k]);
    r.problem = Error{ErrorCode::infeasible,
                      "No tet mesh exists: around the point (" + shortest(w->point[0]) + ", " +
                          shortest(w->point[1]) + ", " + shortest(w->point[2]) +
                          ") the winding number of the surface is " + std::to_string(w->winding) +
                          ", and positive tets only ever add winding."};
    return;
  }
  for (const Hinge& h : r.hinges) {
    if (!h.B0 || *h.B0 >= 0) continue;
    WitnessRecord& record = r.witness.emplace();
    record.vertex = h.vertex;
    record.b0 = *h.B0;
    r.problem = Error{ErrorCode::infeasible,
                      "No tet mesh exists: the faces around vertex " + std::to_string(h.vertex) +
                          " pass through each other so that positive tets cannot fill its" +
                          " neighbourhood (B0 = " + std::to_string(*h.B0) + ")."};
    return;
  }
}

}  // namespace

Result<Inspection> inspect(const Surface& surface, const RunContext& context) {
  Inspection r;
  r.topology = check_topology(surface);
  if (!r.topology.ok()) {
    r.problem = bad_input(r.topology.problems.empty() ? "The surface is not closed, manifold and oriented."
                                                      : r.topology.problems.front());
    return r;
  }
  {
    VertexMatrix V = surface.V;
    Result<UnitBox> box = into_unit_box(V);
    if (!box) {
      r.problem = box.error();
      return r;
    }
    r.box = box.value();
    r.faces_without_area = flat_up_to_rounding({V, surface.F});
  }
  if (r.faces_without_area.empty()) r.faces_without_area = degenerate_faces(surface);
  r.inward = inward_components(surface, r.topology.topology);
  if (!r.faces_without_area.empty()) {
    const std::size_t more = r.faces_without_area.size() - 1;
    r.problem = bad_input("Face " + std::to_string(r.faces_without_area[0]) +
                          (more > 0 ? " (and " + std::to_string(more) + " more)" : "") +
                          " has no area: no tet with a volume can have it as a face.");
    return r;
  }
  if (lies_in_a_plane(surface)) {
    r.problem =
        bad_input("The surface is flat: all vertices lie in one plane, so there is no inside to mesh.");
    return r;
  }
  if (auto stop = context.stop()) return *stop;
  const TriangleBvh bvh(surface.V, surface.F);
  r.pairs = find_self_intersections(surface.V, surface.F);
  if (auto stop = context.stop()) return *stop;
  r.hinges = find_hinges(surface, r.topology.topology, bvh, r.pairs);
  if (auto stop = context.stop()) return *stop;
  Result<WindingRange> range = find_winding_range(surface, r.topology.topology, bvh, r.pairs, context);
  if (!range) return range.error();
  r.winding = std::move(range).value();
  look_for_witness(r);
  if (r.problem || r.hinges.empty()) return r;
  const std::vector<PiercedEdge> pierced = find_pierced_edges(surface, r.topology.topology, r.pairs);
  if (auto stop = context.stop()) return *stop;
  Result<WoundEdges> wound =
      assign_wound_edges(surface, r.topology.topology, bvh, r.hinges, pierced, context);
  if (!wound) return wound.error();
  r.wound = std::move(wound).value();
  return r;
}

InputRecord input_record(const Surface& surface, const Inspection& r) {
  InputRecord record;
  record.vertices = surface.V.rows();
  record.faces = surface.F.rows();
  if (!r.topology.ok()) return record;
  record.components = static_cast<std::int64_t>(r.topology.topology.components.size());
  for (const SurfaceComponent& c : r.topology.topology.components) record.genus.push_back(c.genus);
  record.pairs = static_cast<std::int64_t>(r.pairs.size());
  record.hinges = static_cast<std::int64_t>(r.hinges.size());
  if (!r.problem || r.problem->code == ErrorCode::infeasible) {
    record.winding_min = r.winding.min;
    record.winding_max = r.winding.max;
  }
  return record;
}

std::string advice(const Inspection& r) {
  if (r.problem && r.problem->code == ErrorCode::bad_input) return r.problem->message;
  if (std::all_of(r.inward.begin(), r.inward.end(), [](bool inward) { return inward; }))
    return "The surface is inside out: turn all faces round.";
  if (r.problem) return r.problem->message;
  if (r.pairs.empty())
    return "The surface does not cross itself: any tet mesh generator can mesh it, this one too.";
  if (!r.wound.complete()) return "Overtet will hardly find a tet mesh: " + r.wound.explanation;
  return "The surface passes through itself and nothing is known that would rule out a tet mesh: overtet "
         "mesh will try.";
}

}  // namespace overtet
