#include "src/certificates/rules.h"

namespace overtet::rules {

Finding find_shared(Case& c) {
  if (Status s = c.find_wound_edges(); !s) return s.error();
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
