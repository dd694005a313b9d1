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
  return "No positive mesh exists: around vertex " + std::to_string(c.vertices.front()) +
         " and what else passes through its place no tets fill the space, with as many layers as the winding "
         "numbers have room for.";
}

Fields fields(const SharedCertificate& c) {
  return {{"vertices", c.vertices}, {"layers", c.layers}, {"room", c.room}, {"positions", c.positions}};
}

}  // namespace overtet::rules
