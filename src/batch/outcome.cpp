#include "src/batch/outcome.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "overtet/report.h"

namespace overtet {

namespace {

bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

// The last line that was printed, without the program's name.
std::string last_words(const std::string& printed) {
  std::size_t end = printed.find_last_not_of(" \n\r");
  if (end == std::string::npos) return {};
  const std::size_t begin = printed.find_last_of("\n\r", end);
  std::string line = printed.substr(begin == std::string::npos ? 0 : begin + 1);
  line.erase(line.find_last_not_of(" \n\r") + 1);
  constexpr std::string_view name = "overtet: ";
  return line.starts_with(name) ? line.substr(name.size()) : line;
}

template <class T>
void take(const nlohmann::json& from, const char* key, std::optional<T>& to) {
  if (const auto found = from.find(key); found != from.end() && found->is_number()) to = found->get<T>();
}

// False where there is no report.
bool read_report(const std::string& path, JournalEntry& e) {
  std::ifstream in(path, std::ios::binary);
  const nlohmann::json report =
      nlohmann::json::parse(std::string{std::istreambuf_iterator<char>(in), {}}, nullptr, false);
  if (!report.is_object() || !report.contains("status") || !report["status"].is_string()) return false;
  e.status = report["status"];
  if (const auto m = report.find("message"); m != report.end() && m->is_string()) e.message = *m;
  if (const auto h = report.find("result_hash"); h != report.end() && h->is_string()) e.result_hash = *h;
  if (const auto i = report.find("input"); i != report.end() && i->is_object()) {
    take(*i, "vertices", e.vertices);
    take(*i, "faces", e.faces);
  }
  if (const auto q = report.find("quality"); q != report.end() && q->is_object()) {
    take(*q, "tets", e.tets);
    take(*q, "dihedral_min", e.dihedral_min);
    take(*q, "dihedral_p01", e.dihedral_p01);
  }
  if (const auto p = report.find("peak_rss_bytes"); p != report.end() && p->is_number())
    e.peak_rss_bytes = std::max(e.peak_rss_bytes, p->get<std::int64_t>());
  return true;
}

}  // namespace

Outcome outcome_of(const WorkerEnd& how, const std::string& report, JournalEntry& e) {
  Outcome outcome;
  e.exit_code = how.exit_code;
  e.seconds = how.seconds;
  e.cpu_seconds = how.cpu_seconds;
  e.peak_rss_bytes = how.peak_rss_bytes;
  if (how.killed_late) {
    e.status = name_of(RunStatus::limit);
    e.message = "The time limit was reached; the process did not end at it and was killed.";
    return outcome;
  }
  if (!how.exit_code) {
    e.status = "crashed";
    e.message =
        "Signal " + std::to_string(how.signal) + " (" + ::strsignal(how.signal) + ") ended the process.";
    if (const std::string said = last_words(how.printed); !said.empty()) e.message += " It had said: " + said;
    return outcome;
  }
  outcome.interrupted = *how.exit_code > 128 && *how.exit_code < 128 + 64;
  if (outcome.interrupted || !read_report(report, e)) {
    e.message = last_words(how.printed);
    e.status = outcome.interrupted ? "crashed"
               : *how.exit_code == 0
                   ? name_of(RunStatus::failed)  // the report is as much a result as the mesh
                   : name_of(status_of(static_cast<ErrorCode>(*how.exit_code)));
    if (e.message.empty())
      e.message = "The process ended with code " + std::to_string(*how.exit_code) + " and said nothing.";
  }
  // The words are this very program's own.
  outcome.memory_limit = *how.exit_code == static_cast<int>(ErrorCode::limit) && has(e.message, "memory");
  if (*how.exit_code == static_cast<int>(ErrorCode::io))
    for (const int code : {ENOSPC, EDQUOT, EROFS})
      outcome.disk_full = outcome.disk_full || has(e.message, std::strerror(code));
  return outcome;
}

const char* ending_of(TetFormat format) {
  switch (format) {
    case TetFormat::medit:
      return ".mesh";
    case TetFormat::gmsh22:
    case TetFormat::gmsh41:
      return ".msh";
    case TetFormat::vtu:
      return ".vtu";
    case TetFormat::tetgen:
      return ".node";
    case TetFormat::abaqus:
      return ".inp";
    case TetFormat::vtk:
      return ".vtk";
  }
  return ".mesh";
}

std::string as_utf8(const std::string& text) {
  const std::string quoted =
      nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return nlohmann::json::parse(quoted).get<std::string>();
}

std::vector<std::string> as_utf8(const std::vector<std::string>& words) {
  std::vector<std::string> all;
  for (const std::string& word : words) all.push_back(as_utf8(word));
  return all;
}

}  // namespace overtet
