#include <algorithm>
#include <charconv>

#include "overtet/cleanup.h"

namespace overtet {

namespace {

// in_file(i) for i < n, in runs.
template <class InFile>
std::vector<NumberRun> runs_of(Index n, const InFile& in_file) {
  std::vector<NumberRun> runs;
  for (Index i = 0; i < n;) {
    const std::int64_t number = in_file(i);
    Index end = i + 1;
    while (end < n && in_file(end) == number) ++end;
    if (!runs.empty() && runs.back().in_file >= 0 && runs.back().each == end - i &&
        runs.back().in_file + runs.back().count == number)
      ++runs.back().count;
    else
      runs.push_back({i, number, 1, end - i});
    i = end;
  }
  return runs;
}

// "[a, b, ...]"
template <class Number>
void list(std::string& text, const char* name, Index n, const Number& number) {
  text += std::string("  \"") + name + "\": [";
  char digits[16];
  for (Index i = 0; i < n; ++i) {
    if (i > 0) text += ", ";
    text.append(digits, std::to_chars(digits, digits + sizeof digits, number(i)).ptr);
  }
  text += "]";
}

}  // namespace

CleanupRecord record_of(const Cleanup& cleaned, const SurfaceSource& source) {
  CleanupRecord r;
  for (const Defect& d : cleaned.defects)
    if (is_mended(d.kind)) r.steps.emplace_back(name_of(d.kind), d.count);
  const SurfaceSource now = source_of(cleaned, source);
  r.vertices =
      runs_of(static_cast<Index>(cleaned.surface.V.rows()), [&](Index v) { return now.vertex_in_file(v); });
  r.faces =
      runs_of(static_cast<Index>(cleaned.surface.F.rows()), [&](Index f) { return now.face_in_file(f); });
  for (const Index f : cleaned.turned) {
    if (!r.turned.empty() && r.turned.back()[0] + r.turned.back()[1] == f)
      ++r.turned.back()[1];
    else
      r.turned.push_back({f, 1});
  }
  return r;
}

std::string map_to_json(const Cleanup& cleaned, const SurfaceSource& source) {
  const SurfaceSource now = source_of(cleaned, source);
  std::string text = "{\n";
  list(text, "vertices", static_cast<Index>(cleaned.surface.V.rows()),
       [&](Index v) { return now.vertex_in_file(v); });
  text += ",\n";
  list(text, "faces", static_cast<Index>(cleaned.surface.F.rows()),
       [&](Index f) { return now.face_in_file(f); });
  text += ",\n";
  list(text, "turned", static_cast<Index>(cleaned.turned.size()), [&](Index i) { return cleaned.turned[i]; });
  text += ",\n  \"merged\": [";
  const char* comma = "";
  for (const auto& [given, became] : cleaned.merged) {
    text += comma + std::string("[") + std::to_string(source.vertex_in_file(given)) + ", " +
            std::to_string(became) + "]";
    comma = ", ";
  }
  return text + "]\n}\n";
}

}  // namespace overtet
