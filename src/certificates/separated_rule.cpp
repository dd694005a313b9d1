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
  return "No mesh exists: the component with vertex " + std::to_string(c.vertices.front()) + " at " +
         place_text(c.positions.front()) + ", where B0 = " + std::to_string(c.B0.front()) +
         ", has none by itself, and the components that it touches do not help: moved apart from them, "
         "however little, they cover none of the edges in question.";
}

Fields fields(const SeparatedCertificate& c) {
  return {{"vertices", c.vertices}, {"B0", c.B0}, {"positions", c.positions}, {"apart", c.direction}};
}

}  // namespace overtet::rules
