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
  return "No mesh exists: no tets fill the space around vertex " + std::to_string(c.vertex) + " at " +
         place_text(c.position) + ", where B0 = " + std::to_string(c.B0) +
         ": the polygon in which its faces meet a small sphere bounds no disc that makes extra turns only at "
         "covered edges.";
}

Fields fields(const LinkCertificate& c) { return vertex_fields(c.vertex, c.B0, c.position); }

}  // namespace overtet::rules
