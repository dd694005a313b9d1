#include "kernels/core/box.h"
#include "kernels/core/union_find.h"
#include "overtet/diagnosis.h"
#include "src/api/guarded.h"
#include "src/mesh/thin_spots.h"
#include "src/mesh/tuning.h"
#include "src/pipeline/inspection.h"

namespace overtet {

namespace {

std::vector<std::array<Index, 2>> arrays_of(const std::vector<FacePair>& pairs) {
  std::vector<std::array<Index, 2>> out;
  out.reserve(pairs.size());
  for (const auto& [a, b] : pairs) out.push_back({a, b});
  return out;
}

// Of a surface that is not closed, oriented and manifold.
void add_open_components(SurfaceDiagnosis& out, const Surface& s) {
  UnionFind sets(static_cast<std::size_t>(s.V.rows()));
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 1; k < 3; ++k) sets.join_smaller(s.F(f, 0), s.F(f, k));
  std::vector<Index> number(s.V.rows(), -1);  // of a root
  for (Index f = 0; f < s.F.rows(); ++f) {
    Index& n = number[sets.root(s.F(f, 0))];
    if (n < 0) {
      n = static_cast<Index>(out.components.size());
      out.components.push_back({0, 0, -1, std::nullopt});
    }
    ++out.components[n].faces;
  }
  for (Index v = 0; v < s.V.rows(); ++v)
    if (const Index n = number[sets.root(v)]; n >= 0) ++out.components[n].vertices;
}

void add_shape(SurfaceDiagnosis& out, const Surface& surface, const Diagnosis& d) {
  const TopologyCheck& t = d.topology;
  out.vertices = d.vertices;
  out.faces = d.faces;
  out.closed = t.closed;
  out.manifold = t.manifold_edges && t.manifold_vertices && t.duplicate_faces.empty();
  out.oriented = t.oriented;
  out.problems = t.problems;
  out.degenerate_faces = d.degenerate_faces;
  if (!t.ok()) {
    if (t.indices_valid && t.finite) add_open_components(out, surface);
    return;
  }
  for (std::size_t c = 0; c < t.topology.components.size(); ++c) {
    const SurfaceComponent& one = t.topology.components[c];
    out.components.push_back({one.faces, one.vertices, one.genus, std::nullopt});
    if (c < d.component_volume.size()) out.components.back().signed_volume = d.component_volume[c];
  }
}

void add_crossings(SurfaceDiagnosis& out, const Diagnosis& d, CloseLook look) {
  out.pairs = arrays_of(d.pairs);
  out.pairs_sharing_vertex = d.pairs_sharing_vertex;
  out.pairs_sharing_edge = d.pairs_sharing_edge;
  out.winding_min = d.winding.min;
  out.winding_max = d.winding.max;
  for (std::size_t h = 0; h < d.hinges.size(); ++h) {
    const Hinge& hinge = d.hinges[h];
    out.hinges.push_back(
        {hinge.vertex, hinge.B0, hinge.covering, arrays_of(hinge.crossings), std::move(look.edges[h])});
  }
  for (const WoundEdge& e : d.wound.edges) out.wound_edges.push_back({e.a, e.b, e.k});
  out.odd_groups = d.wound.odd_groups;
  out.crowded = d.wound.crowded;
  out.unfillable = d.wound.unfillable;
  out.unmet = d.wound.unmet;
  out.curves = std::move(look.curves);
}

}  // namespace

Result<SurfaceDiagnosis> diagnose(const Surface& surface, const RunContext& outer) {
  return guarded(outer, [&](const RunContext& context) -> Result<SurfaceDiagnosis> {
    const Result<Inspection> looked = inspect(surface, InspectionDepth::everything, context);
    if (!looked) return looked.error();
    const Inspection& found = looked.value();
    const Diagnosis& d = found.diagnosis;
    SurfaceDiagnosis out;
    out.verdict = d.verdict;
    out.message = found.problem ? found.problem->message : d.message;
    out.certificate = d.certificate;
    out.advice = d.advice;
    add_shape(out, surface, d);
    if (!found.usable()) return out;
    Result<CloseLook> look = look_closely(surface, found, context);
    if (!look) return look.error();
    add_crossings(out, d, std::move(look).value());
    out.thin_limit = kThinWall * diagonal_of(surface.V);
    std::vector<std::uint8_t> crossing(surface.F.rows(), 0);
    for (const auto& [f, g] : d.pairs) crossing[f] = crossing[g] = 1;
    out.thin_spots = find_thin_spots(surface, *d.bvh, out.thin_limit, crossing);
    return out;
  });
}

}  // namespace overtet
