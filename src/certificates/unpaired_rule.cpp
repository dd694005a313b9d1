#include "src/certificates/rules.h"

namespace overtet::rules {

Finding find_unpaired(Case& c) {
  if (Status s = c.find_wound_edges(); !s) return s.error();
  if (c.facts.wound.odd_groups.empty()) return std::optional<Certificate>();
  UnpairedCertificate out;
  out.vertices = c.facts.wound.odd_groups.front();
  for (const Index v : out.vertices) out.B0.push_back(b0_of(c.facts.hinges, v));
  out.positions = positions_of(c.surface, out.vertices);
  return std::optional<Certificate>(std::move(out));
}

std::string explain(const UnpairedCertificate& c) {
  return "No mesh exists: vertex " + std::to_string(c.vertices.front()) + " at " +
         place_text(c.positions.front()) + " has B0 = " + std::to_string(c.B0.front()) +
         (c.vertices.size() == 1
              ? ", an odd number, so its edges must make an odd number of extra turns, but covered edges "
                "join "
                "it to no other vertex with odd B0."
              : ", an odd number, and belongs to a group of " + std::to_string(c.vertices.size()) +
                    " such vertices that covered edges join to each other only; an odd number of them cannot "
                    "be paired.");
}

Fields fields(const UnpairedCertificate& c) {
  return {{"vertices", c.vertices}, {"B0", c.B0}, {"positions", c.positions}};
}

}  // namespace overtet::rules
