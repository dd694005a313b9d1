#include <cmath>
#include <cstdlib>

#include "src/certificates/rules.h"

namespace overtet::rules {

namespace {

std::variant<double, std::string> coordinate(const std::string& text) {
  char* end = nullptr;
  const double x = std::strtod(text.c_str(), &end);
  if (end && *end == '\0' && !text.empty() && std::isfinite(x)) return x;
  return text;
}

}  // namespace

Finding find_winding(Case& c) {
  if (c.facts.winding.witness) return std::optional<Certificate>(*c.facts.winding.witness);
  return std::optional<Certificate>();
}

std::string explain(const WindingCertificate& c) {
  return "No mesh exists: the winding number at " + place_text(c.point) + " is " + std::to_string(c.winding) +
         ", and positive tets cannot make it negative.";
}

Fields fields(const WindingCertificate& c) {
  if (c.doubles_suffice) return {{"point", c.point}, {"winding", c.winding}};
  return {{"point", Coordinates{coordinate(c.exact[0]), coordinate(c.exact[1]), coordinate(c.exact[2])}},
          {"winding", c.winding}};
}

}  // namespace overtet::rules
