#include "src/batch/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "src/batch/batch.h"
#include "src/batch/tuning.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

std::string plain(double x, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, x);
  return text;
}

std::string shortest(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

// Numbers of one kind of all models that have them.
template <class Value>
std::vector<double> values_of(const BatchSummary& s, Value&& value) {
  std::vector<double> all;
  for (const JournalEntry& e : s.models)
    if (const std::optional<double> x = value(e)) all.push_back(*x);
  return all;
}

template <class Value>
const JournalEntry& largest_of(const BatchSummary& s, Value&& value) {
  return *std::max_element(s.models.begin(), s.models.end(),
                           [&](const JournalEntry& a, const JournalEntry& b) { return value(a) < value(b); });
}

// A field of RFC 4180; a leading =, +, - or @ would be a formula to some programs.
std::string field(std::string text) {
  if (!text.empty() && std::string("=+-@").find(text[0]) != std::string::npos) text.insert(0, 1, '\'');
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted.push_back('"');
    quoted.push_back(c);
  }
  return quoted + "\"";
}

template <class T>
std::string number(const std::optional<T>& x) {
  return x ? Json(*x).dump() : std::string();
}

Json spread(const std::vector<double>& values) {
  if (values.empty()) return nullptr;
  double sum = 0;
  for (const double x : values) sum += x;
  return {{"count", values.size()},       {"sum", sum},
          {"min", quantile(values, 0)},   {"median", quantile(values, .5)},
          {"p95", quantile(values, .95)}, {"max", quantile(values, 1)}};
}

std::map<std::string, std::int64_t> statuses_of(const BatchSummary& s) {
  std::map<std::string, std::int64_t> counts;
  for (const JournalEntry& e : s.models) ++counts[e.status];
  return counts;
}

}  // namespace

std::string listed(const std::map<std::string, std::int64_t>& statuses) {
  // Good news first.
  static const char* const order[] = {"exact",     "repaired", "refined", "branched", "infeasible",
                                      "bad-input", "unsolved", "limit",   "failed",   "crashed"};
  std::string text;
  const auto add = [&](const std::string& status, std::int64_t n) {
    text += (text.empty() ? "" : ", ") + std::to_string(n) + " " + status;
  };
  for (const char* status : order)
    if (const auto found = statuses.find(status); found != statuses.end()) add(status, found->second);
  for (const auto& [status, n] : statuses)
    if (std::find(std::begin(order), std::end(order), status) == std::end(order)) add(status, n);
  return text;
}

Result<BatchSummary> summarise(const std::vector<std::string>& journals_or_folders) {
  std::map<std::string, JournalEntry> last;
  BatchSummary summary;
  for (const std::string& path : journals_or_folders) {
    std::vector<std::string> journals = {path};
    std::error_code none;
    if (std::filesystem::is_directory(path, none)) {
      Result<std::vector<std::string>> found = journals_in(path);
      if (!found) return found.error();
      if (found.value().empty())
        return Error{ErrorCode::usage, "The folder " + path + " has no journal of a batch (journal.jsonl)."};
      journals = std::move(found).value();
    }
    for (const std::string& journal : journals) {
      Result<JournalContents> read = read_journal(journal);
      if (!read) return read.error();
      for (const std::int64_t line : read.value().wrong_lines)
        summary.notes.push_back(journal + ": line " + std::to_string(line) + " is no entry; it is skipped.");
      add_last(std::move(read).value(), last);
    }
  }
  for (auto& [name, entry] : last) summary.models.push_back(std::move(entry));
  return summary;
}

bool has_mesh(const JournalEntry& entry) { return entry.exit_code == 0 && entry.status != "failed"; }

double peak_mib(const JournalEntry& entry) {
  return std::ldexp(static_cast<double>(entry.peak_rss_bytes), -20);
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size())));
  const auto at = values.begin() + std::clamp<std::ptrdiff_t>(rank - 1, 0, std::ssize(values) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Histogram histogram(const std::vector<double>& values, bool logarithmic) {
  std::vector<double> at;
  for (const double x : values)
    if (std::isfinite(x) && (!logarithmic || x > 0)) at.push_back(logarithmic ? std::log10(x) : x);
  Histogram h;
  if (at.empty()) return h;
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  // Half decades, or about as many steps of 1, 2 or 5 times a power of ten.
  double step = .5;
  if (!logarithmic) {
    step = std::pow(
        10, std::floor(std::log10(std::max({*high - *low, 1e-3 * std::abs(*high), 1e-12}) / kHistogramBars)));
    for (const double factor : {2., 2.5, 2.})
      if ((*high - *low) / step > kHistogramBars) step *= factor;
  }
  const double first = std::floor(*low / step);
  const auto bars = static_cast<std::size_t>(std::floor(*high / step) - first) + 1;
  h.counts.assign(bars, 0);
  for (std::size_t i = 0; i <= bars; ++i) {
    const double limit = (first + static_cast<double>(i)) * step;
    h.limits.push_back(logarithmic ? std::pow(10, limit) : limit);
  }
  for (const double x : at)
    ++h.counts[std::min(bars - 1, static_cast<std::size_t>(std::max(0., std::floor(x / step) - first)))];
  return h;
}

std::string to_text(const BatchSummary& s) {
  std::string text = "models    " + std::to_string(s.models.size()) + "\n";
  if (s.models.empty()) return text;
  text += "answers   " + listed(statuses_of(s)) + "\n";
  const auto seconds = values_of(s, [](const auto& e) { return std::optional(e.seconds); });
  const auto cpu = values_of(s, [](const auto& e) { return std::optional(e.cpu_seconds); });
  const auto memory = values_of(s, [](const auto& e) { return std::optional(peak_mib(e)); });
  double sum = 0, cpu_sum = 0;
  for (const double x : seconds) sum += x;
  for (const double x : cpu) cpu_sum += x;
  text += "time      " + plain(sum, 1) + " s in all, " + plain(cpu_sum, 1) + " s of CPU; a model: median " +
          plain(quantile(seconds, .5), 2) + " s, 95 % below " + plain(quantile(seconds, .95), 2) +
          " s, worst " + plain(quantile(seconds, 1), 1) + " s (" +
          largest_of(s, [](const auto& e) { return e.seconds; }).name + ")\n";
  text += "memory    median " + plain(quantile(memory, .5), 0) + " MiB, 95 % below " +
          plain(quantile(memory, .95), 0) + " MiB, worst " + plain(quantile(memory, 1), 0) + " MiB (" +
          largest_of(s, [](const auto& e) { return e.peak_rss_bytes; }).name + ")\n";
  const auto angles = values_of(s, [](const auto& e) { return e.dihedral_min; });
  double tets = 0;
  for (const JournalEntry& e : s.models) tets += static_cast<double>(e.tets.value_or(0));
  if (!angles.empty())
    text += "meshes    " + std::to_string(angles.size()) + ", " + plain(tets, 0) +
            " tets; smallest dihedral angle: median " + plain(quantile(angles, .5), 1) + " degrees, worst " +
            shortest(quantile(angles, 0)) + " degrees\n";
  std::size_t shown = 0, without = 0;
  for (const JournalEntry& e : s.models) without += has_mesh(e) ? 0 : 1;
  for (const JournalEntry& e : s.models) {
    if (has_mesh(e)) continue;
    if (shown++ == kShownModels) break;
    text += "  " + e.name + ": " + e.status + ": " + e.message + "\n";
  }
  if (without > kShownModels)
    text += "  and " + std::to_string(without - kShownModels) + " more without a mesh\n";
  return text;
}

std::string to_csv(const BatchSummary& s) {
  std::string text =
      "name,status,exit_code,seconds,cpu_seconds,peak_mib,threads,tries,vertices,faces,tets,dihedral_min,"
      "dihedral_p01,result_hash,input,input_bytes,sha256,host,shard,ended,message\r\n";
  for (const JournalEntry& e : s.models) {
    const std::string fields[] = {field(e.name),
                                  field(e.status),
                                  number(e.exit_code),
                                  plain(e.seconds, 3),
                                  plain(e.cpu_seconds, 3),
                                  plain(peak_mib(e), 1),
                                  std::to_string(e.threads),
                                  std::to_string(e.tries),
                                  number(e.vertices),
                                  number(e.faces),
                                  number(e.tets),
                                  number(e.dihedral_min),
                                  number(e.dihedral_p01),
                                  field(e.result_hash),
                                  field(e.input),
                                  std::to_string(e.input_bytes),
                                  field(e.sha256),
                                  field(e.host),
                                  field(e.shard),
                                  field(e.ended),
                                  field(e.message)};
    for (std::size_t i = 0; i < std::size(fields); ++i) text.append(i > 0 ? "," : "").append(fields[i]);
    text += "\r\n";
  }
  return text;
}

std::string to_json(const BatchSummary& s) {
  Json j, statuses = Json::object();
  for (const auto& [status, count] : statuses_of(s)) statuses[status] = count;
  j["totals"] = {
      {"models", s.models.size()},
      {"statuses", statuses},
      {"seconds", spread(values_of(s, [](const auto& e) { return std::optional(e.seconds); }))},
      {"cpu_seconds", spread(values_of(s, [](const auto& e) { return std::optional(e.cpu_seconds); }))},
      {"peak_rss_bytes",
       spread(values_of(s, [](const auto& e) { return std::optional(double(e.peak_rss_bytes)); }))},
      {"tets", spread(values_of(s, [](const auto& e) { return std::optional<double>(e.tets); }))},
      {"dihedral_min", spread(values_of(s, [](const auto& e) { return e.dihedral_min; }))}};
  j["models"] = Json::array();
  for (const JournalEntry& e : s.models) j["models"].push_back(Json::parse(to_line(e)));
  if (!s.notes.empty()) j["notes"] = s.notes;
  return j.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace overtet
