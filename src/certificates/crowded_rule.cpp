#include "src/certificates/rules.h"

namespace overtet::rules {

Finding find_crowded(Case& c) {
  if (Status s = c.find_wound_edges(); !s) return s.error();
  if (c.facts.wound.crowded.empty()) return std::optional<Certificate>();
  const Index v = c.facts.wound.crowded.front();
  return std::optional<Certificate>(
      CrowdedCertificate{v, b0_of(c.facts.hinges, v), position_of(c.surface, v)});
}

std::string explain(const CrowdedCertificate& c) {
  return "No mesh exists: vertex " + std::to_string(c.vertex) + " at " + place_text(c.position) +
         " has B0 = " + std::to_string(c.B0) +
         ", and too few of its edges are covered to take the extra turns that this needs.";
}

Fields fields(const CrowdedCertificate& c) { return vertex_fields(c.vertex, c.B0, c.position); }

}  // namespace overtet::rules
