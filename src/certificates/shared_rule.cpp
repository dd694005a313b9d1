#include <algorithm>

#include "kernels/predicates/predicates.h"
#include "src/certificates/rules.h"
#include "src/covering/shared_points.h"

namespace overtet::rules {

namespace {

// Vertices in the plane of a face that theirs intersect: all that lie on other parts of the surface.
std::vector<Index> touching_vertices(const Surface& s, const std::vector<FacePair>& pairs) {
  std::vector<Index> out;
  const auto point = [&](Index v) { return s.V.data() + 3 * std::int64_t{v}; };
  const auto look = [&](Index f, Index g) {
    const auto corner = s.F.row(g);
    for (const Index v : s.F.row(f))
      if ((corner.array() != v).all() &&
          orient3d(point(corner[0]), point(corner[1]), point(corner[2]), point(v)) == 0)
        out.push_back(v);
  };
  for (const auto& [f, g] : pairs) {
    look(f, g);
    look(g, f);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

// At hinges, where find_wound_edges() has looked, and at all vertices that touch other parts of the surface.
Status look_at_shared_points(Case& c) {
  if (Status s = c.find_wound_edges(); !s) return s;
  Facts& facts = c.facts;
  if (facts.wound.forbidden()) return success();
  auto found =
      overtet::find_shared(c.surface, facts.topology.topology, *facts.bvh, facts.hinges, facts.pierced_edges,
                           touching_vertices(c.surface, facts.pairs), c.context);
  if (!found) return found.error();
  if (found.value().empty()) return success();
  facts.wound.shared = found.value().front();
  facts.wound.unfillable = facts.wound.unmet = facts.wound.shared->vertices;
  return success();
}

}  // namespace

Finding find_shared(Case& c) {
  if (Status s = look_at_shared_points(c); !s) return s.error();
  if (!c.facts.wound.shared) return std::optional<Certificate>();
  const SharedPoint& p = *c.facts.wound.shared;
  return std::optional<Certificate>(
      SharedCertificate{p.vertices, p.layers, positions_of(c.surface, p.vertices), p.room});
}

std::string explain(const SharedCertificate& c) {
  return "No mesh exists: all that passes through " + place_text(c.positions.front()) +
         ", the place of vertex " + std::to_string(c.vertices.front()) +
         ", needs more layers of tets there than the winding numbers leave room for.";
}

Fields fields(const SharedCertificate& c) {
  return {{"vertices", c.vertices}, {"layers", c.layers}, {"room", c.room}, {"positions", c.positions}};
}

}  // namespace overtet::rules
