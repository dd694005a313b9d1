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
  return "No positive mesh exists: at vertex " + std::to_string(c.vertices.front()) + " the integer B0 is " +
         std::to_string(c.B0.front()) +
         (c.vertices.size() == 1
              ? ", so an odd number of its edges would have to turn once more than they show, and the edges "
                "whose outer side is covered all along lead from there to no other such vertex."
              : ", and the " + std::to_string(c.vertices.size()) +
                    " vertices with odd B0 that covered edges join to it cannot be paired.");
}

Fields fields(const UnpairedCertificate& c) {
  return {{"vertices", c.vertices}, {"B0", c.B0}, {"positions", c.positions}};
}

}  // namespace overtet::rules
