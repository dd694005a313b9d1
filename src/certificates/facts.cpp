#include "src/certificates/facts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <string>
#include <utility>

#include "kernels/core/tuning.h"
#include "src/arrangement/intersection_graph.h"
#include "src/certificates/tuning.h"
#include "src/run/stopwatch.h"

namespace overtet {

namespace {

void count_shared(const Surface& surface, Facts& d) {
  for (const auto& [f, g] : d.pairs) {
    int shared = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) shared += surface.F(f, i) == surface.F(g, j);
    d.pairs_sharing_vertex += shared == 1;
    d.pairs_sharing_edge += shared == 2;
  }
}

}  // namespace

Facts check_shape(const Surface& surface) {
  Facts d;
  const Stopwatch time(d.times.topology);
  d.vertices = static_cast<Index>(surface.V.rows());
  d.faces = static_cast<Index>(surface.F.rows());
  d.topology = check_topology(surface);
  if (d.topology.indices_valid && d.topology.finite) d.degenerate_faces = degenerate_faces(surface);
  return d;
}

std::vector<double> component_volumes(const Surface& surface, const SurfaceTopology& topology) {
  std::vector<double> volume(topology.components.size(), 0);
  const Eigen::RowVector3d centre = surface.V.colwise().mean();
  for (Index f = 0; f < surface.F.rows(); ++f) {
    const Eigen::RowVector3d a = surface.V.row(surface.F(f, 0)) - centre,
                             b = surface.V.row(surface.F(f, 1)) - centre,
                             c = surface.V.row(surface.F(f, 2)) - centre;
    volume[topology.component_of_face[f]] += a.dot(b.cross(c)) / 6;
  }
  return volume;
}

Status gather_facts(const Surface& surface, bool full_winding_range, const RunContext& context, Facts& d) {
  if (auto stop = context.stop()) return *stop;
  context.report("diagnose", 0.1, "looking for faces that intersect");
  const SurfaceTopology& topology = d.topology.topology;
  d.component_volume = component_volumes(surface, topology);
  auto bvh = std::make_shared<TriangleBvh>();
  {
    const Stopwatch time(d.times.pairs);
    bvh->build(surface.V, surface.F);
    d.pairs = find_self_intersections(surface.V, surface.F, *bvh);
    d.bvh = bvh;
    count_shared(surface, d);
  }
  if (auto stop = context.stop()) return *stop;
  context.report("diagnose", 0.4, std::to_string(d.pairs.size()) + " pairs");
  {
    const Stopwatch time(d.times.hinges);
    d.hinges = find_hinges(surface, topology, *bvh, d.pairs);
  }
  context.report("diagnose", 0.5, std::to_string(d.hinges.size()) + " hinges");
  {
    const Stopwatch time(d.times.winding);
    WindingRangeOptions range;
    range.stop_at_first_negative = !full_winding_range;
    d.graph = std::make_shared<IntersectionGraph>(surface, topology, *bvh, d.pairs);
    auto winding = find_winding_range(surface, topology, *bvh, *d.graph, context, range);
    if (!winding.ok()) return winding.error();
    d.winding = std::move(winding).value();
  }
  {
    const Stopwatch time(d.times.wound_edges);
    d.pierced_edges = find_pierced_edges(surface, topology, d.pairs);
  }
  return success();
}

bool is_checkable(const Hinge& hinge) { return hinge.opening > kRounding; }

const Hinge* clearest_negative(const std::vector<Hinge>& hinges) {
  const Hinge* best = nullptr;
  for (const Hinge& h : hinges)
    if (h.B0 && *h.B0 < 0 && is_checkable(h) && (!best || h.opening > best->opening)) best = &h;
  return best;
}

int b0_of(const std::vector<Hinge>& hinges, Index vertex) {
  const auto at = std::lower_bound(hinges.begin(), hinges.end(), vertex,
                                   [](const Hinge& h, Index v) { return h.vertex < v; });
  return at != hinges.end() && at->vertex == vertex ? at->B0.value_or(0) : 0;
}

std::array<double, 3> position_of(const Surface& surface, Index vertex) {
  return {surface.V(vertex, 0), surface.V(vertex, 1), surface.V(vertex, 2)};
}

std::vector<std::array<double, 3>> positions_of(const Surface& surface, const std::vector<Index>& vertices) {
  std::vector<std::array<double, 3>> out;
  for (const Index v : vertices) out.push_back(position_of(surface, v));
  return out;
}

}  // namespace overtet
