#include "overtet/certificate.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "src/certificates/rules.h"

namespace overtet {

namespace {

using rules::Coordinates;
using Json = nlohmann::ordered_json;

struct AsJson {
  template <class T>
  Json operator()(const T& value) const {
    return Json(value);
  }
  Json operator()(const Coordinates& point) const {
    Json out = Json::array();
    for (const auto& x : point) out.push_back(std::visit(AsJson{}, x));
    return out;
  }
};

}  // namespace

const char* rule_name(const Certificate& certificate) {
  return std::visit([](const auto& c) { return rules::name(c); }, certificate);
}

bool forbids_branch_lines(const Certificate& certificate) {
  return std::visit([](const auto& c) { return rules::forbids_branch_lines(c); }, certificate);
}

std::string explain(const Certificate& certificate) {
  return std::visit([](const auto& c) { return rules::explain(c); }, certificate);
}

std::string to_json(const Certificate& certificate) {
  Json j;
  j["rule"] = rule_name(certificate);
  for (const auto& [key, value] : std::visit([](const auto& c) { return rules::fields(c); }, certificate))
    j[key] = std::visit(AsJson{}, value);
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

namespace rules {

std::string place_text(const std::array<double, 3>& point) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", point[0], point[1], point[2]);
  return text;
}

Fields vertex_fields(Index vertex, int B0, const std::array<double, 3>& position) {
  return {{"vertices", std::vector<int>{vertex}},
          {"B0", std::vector<int>{B0}},
          {"positions", std::vector<std::array<double, 3>>{position}}};
}

}  // namespace rules

}  // namespace overtet
