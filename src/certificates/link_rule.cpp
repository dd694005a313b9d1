#include "src/certificates/rules.h"

namespace overtet::rules {

Finding find_link(Case& c) {
  if (Status s = c.find_wound_edges(); !s) return s.error();
  const WoundEdges& wound = c.facts.wound;
  if (wound.shared || wound.unfillable.empty()) return std::optional<Certificate>();
  const Index v = wound.unfillable.front();
  return std::optional<Certificate>(LinkCertificate{v, b0_of(c.facts.hinges, v), position_of(c.surface, v)});
}

std::string explain(const LinkCertificate& c) {
  return "No positive mesh exists: at vertex " + std::to_string(c.vertex) + " the integer B0 is " +
         std::to_string(c.B0) +
         ", and no tets fill its surroundings: the polygon in which its faces meet a small sphere bounds no "
         "disc that turns only at edges covered all along.";
}

Fields fields(const LinkCertificate& c) { return vertex_fields(c.vertex, c.B0, c.position); }

}  // namespace overtet::rules
