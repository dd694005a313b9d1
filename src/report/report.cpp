#include "overtet/report.h"

#include <nlohmann/json.hpp>

#include "overtet/version.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

Json value_of(const Figure& figure) {
  return std::visit([](const auto& x) { return Json(x); }, figure.second);
}

Json runs_of(const std::vector<NumberRun>& runs) {
  Json j = Json::array();
  for (const NumberRun& r : runs) j.push_back({r.first, r.in_file, r.count, r.each});
  return j;
}

Json to_json(const CleanupRecord& r) {
  Json j;
  j["steps"] = Json::object();
  for (const auto& [kind, count] : r.steps) j["steps"][kind] = count;
  j["vertices"] = runs_of(r.vertices);
  j["faces"] = runs_of(r.faces);
  j["turned"] = r.turned;
  return j;
}

Json to_json(const RatioRange& r) {
  return {{"least", r.least}, {"p01", r.p01}, {"p50", r.p50}, {"p99", r.p99}, {"most", r.most}};
}

}  // namespace

const char* name_of(RunStatus status) {
  switch (status) {
    case RunStatus::exact:
      return "exact";
    case RunStatus::repaired:
      return "repaired";
    case RunStatus::refined:
      return "refined";
    case RunStatus::branched:
      return "branched";
    case RunStatus::flipped:
      return "flipped";
    case RunStatus::embedded:
      return "embedded";
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

RunStatus status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::bad_input:
      return RunStatus::bad_input;
    case ErrorCode::unsolved:
      return RunStatus::unsolved;
    case ErrorCode::infeasible:
      return RunStatus::infeasible;
    case ErrorCode::limit:
      return RunStatus::limit;
    case ErrorCode::interrupted:
      return RunStatus::interrupted;
    case ErrorCode::usage:
    case ErrorCode::io:
    case ErrorCode::internal:
      return RunStatus::failed;
  }
  return RunStatus::failed;
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
  if (r.input.cleanup) input["clean_up"] = to_json(*r.input.cleanup);
  j["status"] = name_of(r.status);
  j["message"] = r.message;
  if (r.certificate) j["witness"] = Json::parse(to_json(*r.certificate));
  j["moved"] = {{"vertices", r.moved_vertices},
                {"max_relative", r.max_relative_move},
                {"mean_relative", r.mean_relative_move},
                {"ids", r.moved_ids}};
  if (r.status == RunStatus::refined)
    j["refined"] = {{"subdivided", r.subdivided_faces}, {"faces", r.face_of_piece}};
  if (r.status == RunStatus::branched) j["branch_edges"] = r.branch_edges;
  if (r.status == RunStatus::flipped) j["flipped_tets"] = r.flipped_tets;
  if (const auto& a = r.moved_angles)
    j["moved"]["angles"] = {{"least", a->least},
                            {"bound", a->bound},
                            {"bound_as_moved", a->bound_as_moved},
                            {"bound_elsewhere", a->bound_elsewhere}};
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
                    {"volume", r.quality->volume},
                    {"coincident_vertices", r.quality->coincident_vertices},
                    {"closest_pair", r.quality->closest_pair}};
  if (const auto& e = r.embedding)
    j["embedding"] = {{"area", to_json(e->area)},
                      {"edge", to_json(e->edge)},
                      {"area_within_20", e->area_within_20},
                      {"collapsed", e->collapsed},
                      {"laid_aside", r.laid_aside}};
  j["seconds"] = r.seconds;
  j["peak_rss_bytes"] = r.peak_rss_bytes;
  j["result_hash"] = r.result_hash.empty() ? Json() : Json(r.result_hash);
  // Messages quote what users wrote, which need not be UTF-8.
  return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace overtet
