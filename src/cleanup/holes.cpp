#include "src/cleanup/holes.h"

#include <algorithm>

#include "src/mesh/topology.h"

namespace overtet {

std::vector<DefectPlace> find_holes(const VertexMatrix& V, const TriangleMatrix& F, const RawEdges& edges,
                                    const Oriented& oriented, std::size_t most_listed) {
  struct Step {
    Index from, to, half_edge;
    bool done;
  };
  std::vector<Step> steps;
  for (const EdgeGroup& g : edges.others) {
    if (g.count != 1) continue;
    const Index h = edges.list[g.begin];
    Index from = half_edge_source(F, h), to = half_edge_target(F, h);
    // Along the hole, as a face that fills it would run.
    if (!oriented.turned[half_edge_face(h)]) std::swap(from, to);
    steps.push_back({from, to, h, false});
  }
  const auto at = [&](Index v) { return edges.place[v]; };
  std::sort(steps.begin(), steps.end(), [&](const Step& s, const Step& t) {
    return at(s.from) != at(t.from) ? at(s.from) < at(t.from) : s.half_edge < t.half_edge;
  });
  std::vector<DefectPlace> holes;
  for (Step& first : steps) {
    if (first.done) continue;
    DefectPlace hole;
    for (Step* s = &first; s;) {
      s->done = true;
      ++hole.edges;
      hole.length += (V.row(s->to) - V.row(s->from)).norm();
      if (hole.vertices.size() < most_listed) {
        hole.vertices.push_back(s->from);
        hole.faces.push_back(half_edge_face(s->half_edge));
      }
      if (at(s->to) == at(first.from)) break;
      auto next = std::lower_bound(steps.begin(), steps.end(), at(s->to),
                                   [&](const Step& t, Index place) { return at(t.from) < place; });
      while (next != steps.end() && at(next->from) == at(s->to) && next->done) ++next;
      s = next != steps.end() && at(next->from) == at(s->to) ? &*next : nullptr;
    }
    for (int k = 0; k < 3; ++k) hole.position[k] = V(first.from, k);
    holes.push_back(std::move(hole));
  }
  std::stable_sort(holes.begin(), holes.end(),
                   [](const DefectPlace& a, const DefectPlace& b) { return a.edges > b.edges; });
  return holes;
}

}  // namespace overtet
