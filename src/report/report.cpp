#include "src/report/report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "overtet/version.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

Json value_of(const Figure& figure) {
  return std::visit([](const auto& x) { return Json(x); }, figure.second);
}

// Coordinates that are plain numbers appear as numbers, exact fractions as strings.
Json coordinate(const std::string& text) {
  char* end = nullptr;
  const double x = std::strtod(text.c_str(), &end);
  return end && *end == '\0' && !text.empty() && std::isfinite(x) ? Json(x) : Json(text);
}

// "point" and "vertex" at the top are proofs by themselves; the other rules must not have them there.
Json json_of(const WitnessRecord& w) {
  Json j;
  j["rule"] = name_of(w.rule);
  switch (w.rule) {
    case WitnessRecord::Rule::winding:
      j["point"] = Json::array();
      for (const std::string& c : w.point) j["point"].push_back(coordinate(c));
      j["winding"] = w.winding;
      return j;
    case WitnessRecord::Rule::vertex:
      j["vertex"] = w.vertices[0];
      j["B0"] = w.B0[0];
      j["position"] = w.positions[0];
      return j;
    case WitnessRecord::Rule::fold:
    case WitnessRecord::Rule::unpaired:
    case WitnessRecord::Rule::crowded:
    case WitnessRecord::Rule::link:
      j["vertices"] = w.vertices;
      j["B0"] = w.B0;
      j["positions"] = w.positions;
      if (w.apart) j["apart"] = *w.apart;
      return j;
    case WitnessRecord::Rule::shared:
      j["vertices"] = w.vertices;
      j["layers"] = w.layers;
      j["room"] = w.room;
      j["positions"] = w.positions;
      return j;
    case WitnessRecord::Rule::stack:
      j["face"] = w.face;
      j["place"] = w.point;
      j["vertices"] = w.vertices;
      j["moves"] = w.moves;
      j["winding"] = w.winding;
      j["positions"] = w.positions;
      return j;
    case WitnessRecord::Rule::gluing:
      j["pairs"] = w.pairs;
      j["layers"] = w.layers;
      j["edges"] = w.edges;
      j["positions"] = w.positions;
      return j;
  }
  return j;
}

}  // namespace

const char* name_of(WitnessRecord::Rule rule) {
  switch (rule) {
    case WitnessRecord::Rule::winding:
      return "winding";
    case WitnessRecord::Rule::vertex:
      return "vertex";
    case WitnessRecord::Rule::fold:
      return "fold";
    case WitnessRecord::Rule::unpaired:
      return "unpaired";
    case WitnessRecord::Rule::crowded:
      return "crowded";
    case WitnessRecord::Rule::link:
      return "link";
    case WitnessRecord::Rule::shared:
      return "shared";
    case WitnessRecord::Rule::stack:
      return "stack";
    case WitnessRecord::Rule::gluing:
      return "gluing";
  }
  return "";
}

std::string to_json(const WitnessRecord& witness) { return json_of(witness).dump(); }

const char* name_of(RunStatus status) {
  switch (status) {
    case RunStatus::exact:
      return "exact";
    case RunStatus::repaired:
      return "repaired";
    case RunStatus::infeasible:
      return "infeasible";
    case RunStatus::unsolved:
      return "unsolved";
    case RunStatus::bad_input:
      return "bad-input";
    case RunStatus::limit:
      return "limit";
    case RunStatus::interrupted:
      return "interrupted";
    case RunStatus::failed:
      return "failed";
  }
  return "failed";
}

std::string to_json(const Report& r) {
  Json j;
  j["version"] = version();
  j["options"] = Json::object();
  for (const Figure& f : r.options) j["options"][f.first] = value_of(f);
  Json& input = j["input"];
  input = {{"vertices", r.input.vertices}, {"faces", r.input.faces}, {"components", r.input.components},
           {"genus", r.input.genus},       {"pairs", r.input.pairs}, {"hinges", r.input.hinges}};
  input["winding_min"] = r.input.winding_min ? Json(*r.input.winding_min) : Json();
  input["winding_max"] = r.input.winding_max ? Json(*r.input.winding_max) : Json();
  input["format"] = r.input.format;
  if (!r.input.notes.empty()) input["notes"] = r.input.notes;
  j["status"] = name_of(r.status);
  j["message"] = r.message;
  if (r.witness) j["witness"] = json_of(*r.witness);
  j["moved"] = {{"vertices", r.moved_vertices},
                {"max_relative", r.max_relative_move},
                {"mean_relative", r.mean_relative_move},
                {"ids", r.moved_ids}};
  j["stages"] = Json::array();
  for (const StageRecord& s : r.stages) {
    Json stage = {{"name", s.name},
                  {"seconds", s.seconds},
                  {"cpu_seconds", s.cpu_seconds},
                  {"iterations", s.iterations}};
    for (const Figure& f : s.figures) stage[f.first] = value_of(f);
    j["stages"].push_back(stage);
  }
  if (r.quality)
    j["quality"] = {{"tets", r.quality->tets},
                    {"dihedral_min", r.quality->dihedral_min},
                    {"dihedral_p01", r.quality->dihedral_p01},
                    {"dihedral_max", r.quality->dihedral_max},
                    {"volume", r.quality->volume}};
  j["seconds"] = r.seconds;
  j["peak_rss_bytes"] = r.peak_rss_bytes;
  j["result_hash"] = r.result_hash.empty() ? Json() : Json(r.result_hash);
  // Messages quote what users wrote, which need not be UTF-8.
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace overtet
