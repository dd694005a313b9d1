#include "src/covering/gluing.h"

#include "src/certificates/rules.h"

namespace overtet::rules {

Finding find_gluing(Case& c) {
  if (c.facts.pairs.empty()) return std::optional<Certificate>();
  const Result<GluingAnswer> answer =
      check_gluing(c.surface, c.facts.topology.topology, *c.facts.bvh, *c.facts.graph, c.context);
  if (!answer.ok()) return answer.error();
  if (answer.value().verdict != GluingVerdict::conflict) return std::optional<Certificate>();
  return std::optional<Certificate>(answer.value().conflict);
}

std::string explain(const GluingCertificate& c) {
  std::string text = "No mesh exists: the layers of the solid cannot be glued without a branch line";
  if (!c.crossings.empty())
    text += " where faces " + std::to_string(c.crossings[0].faces[0]) + " and " +
            std::to_string(c.crossings[0].faces[1]) + " cross near " + place_text(c.crossings[0].position) +
            (c.crossings.size() == 1 ? ""
             : c.crossings.size() == 2
                 ? ", together with 1 other crossing"
                 : ", together with " + std::to_string(c.crossings.size() - 1) + " other crossings");
  return text + ".";
}

Fields fields(const GluingCertificate& c) {
  std::vector<std::array<int, 2>> pairs;
  std::vector<int> layers;
  std::vector<std::array<double, 3>> positions;
  for (const GluingCertificate::Crossing& x : c.crossings) {
    pairs.push_back(x.faces);
    layers.push_back(x.layers);
    positions.push_back(x.position);
  }
  return {{"pairs", pairs}, {"layers", layers}, {"edges", c.edges}, {"positions", positions}};
}

}  // namespace overtet::rules
