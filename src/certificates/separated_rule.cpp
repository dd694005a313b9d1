#include "src/certificates/rules.h"
#include "src/certificates/separated.h"

namespace overtet::rules {

Finding find_separated(Case& c) {
  if (c.facts.hinges.empty()) return std::optional<Certificate>();
  auto found = find_separated_part(c.surface, c.facts.topology.topology, c.facts.hinges, c.context);
  if (!found.ok()) return found.error();
  if (!found.value()) return std::optional<Certificate>();
  // What was assigned to the whole leads to no mesh.
  c.facts.wound = {};
  c.facts.wound.odd_groups = {found.value()->vertices};
  c.facts.wound.unmet = found.value()->vertices;
  return std::optional<Certificate>(std::move(*found.value()));
}

std::string explain(const SeparatedCertificate& c) {
  return "No positive mesh exists: the part of the surface with vertex " +
         std::to_string(c.vertices.front()) + " (B0 = " + std::to_string(c.B0.front()) +
         " there) has none, and moved away from the others by as little as one likes, it gets nothing from "
         "them that would help.";
}

Fields fields(const SeparatedCertificate& c) {
  return {{"vertices", c.vertices}, {"B0", c.B0}, {"positions", c.positions}, {"apart", c.direction}};
}

}  // namespace overtet::rules
