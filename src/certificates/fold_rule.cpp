#include "src/certificates/rules.h"

namespace overtet::rules {

Finding find_fold(Case& c) {
  const Hinge* last = nullptr;
  for (const Hinge& h : c.facts.hinges)
    if (h.B0 && *h.B0 < 0 && !is_checkable(h)) last = &h;
  if (!last) return std::optional<Certificate>();
  return std::optional<Certificate>(
      FoldCertificate{last->vertex, *last->B0, position_of(c.surface, last->vertex)});
}

std::string explain(const FoldCertificate& c) {
  return "No mesh exists: at vertex " + std::to_string(c.vertex) + ", at " + place_text(c.position) +
         ", two faces lie flat on each other, or almost, and leave no room for a tet between them.";
}

Fields fields(const FoldCertificate& c) { return vertex_fields(c.vertex, c.B0, c.position); }

}  // namespace overtet::rules
