#include "src/certificates/rules.h"

namespace overtet::rules {

Finding find_area(Case& c) {
  if (c.facts.degenerate_faces.empty()) return std::optional<Certificate>();
  AreaCertificate found;
  found.face = c.facts.degenerate_faces.front();
  for (const Index v : c.surface.F.row(found.face)) found.vertices.push_back(v);
  found.positions = positions_of(c.surface, found.vertices);
  return std::optional<Certificate>(std::move(found));
}

std::string explain(const AreaCertificate& c) {
  std::string corners;
  for (const Index v : c.vertices) corners += (corners.empty() ? "" : ", ") + std::to_string(v);
  return "No mesh exists: face " + std::to_string(c.face) + " (vertices " + corners +
         ", counted from 0) has no area, so no tet with volume can have it as a face.";
}

Fields fields(const AreaCertificate& c) {
  return {{"face", c.face}, {"vertices", c.vertices}, {"positions", c.positions}};
}

}  // namespace overtet::rules
