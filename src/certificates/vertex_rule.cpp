#include "src/certificates/rules.h"

namespace overtet::rules {

Finding find_vertex(Case& c) {
  const Hinge* hinge = clearest_negative(c.facts.hinges);
  if (!hinge) return std::optional<Certificate>();
  return std::optional<Certificate>(
      VertexCertificate{hinge->vertex, *hinge->B0, position_of(c.surface, hinge->vertex)});
}

std::string explain(const VertexCertificate& c) {
  return "No mesh exists: vertex " + std::to_string(c.vertex) + " at " + place_text(c.position) +
         " has B0 = " + std::to_string(c.B0) +
         ", and positive tets cannot fill the space around a vertex with negative B0.";
}

Fields fields(const VertexCertificate& c) {
  return {{"vertex", c.vertex}, {"B0", c.B0}, {"position", c.position}};
}

}  // namespace overtet::rules
