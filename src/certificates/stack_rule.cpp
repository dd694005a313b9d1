#include "src/certificates/rules.h"
#include "src/certificates/stacks.h"

namespace overtet::rules {

Finding find_stack(Case& c) {
  auto stack = find_stack_certificate(c.surface, *c.facts.bvh, c.facts.pairs, c.context);
  if (!stack.ok()) return stack.error();
  if (!stack.value()) return std::optional<Certificate>();
  return std::optional<Certificate>(std::move(*stack.value()));
}

std::string explain(const StackCertificate& c) {
  return "No mesh exists: at " + place_text(c.point) + " face " + std::to_string(c.face) +
         " and other faces lie on each other in an order that certain moves of their vertices, however "
         "small, "
         "turn inside out.";
}

Fields fields(const StackCertificate& c) {
  return {{"face", c.face},         {"place", c.exact},
          {"vertices", c.vertices}, {"moves", c.moves},
          {"winding", c.winding},   {"positions", std::vector<std::array<double, 3>>{c.point}}};
}

}  // namespace overtet::rules
