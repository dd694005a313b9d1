#include "src/pipeline/stage_clock.h"

#include <sys/resource.h>

#include <cstdio>
#include <string>
#include <variant>

namespace overtet {

double cpu_seconds() {
  double sum = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage u{};
    if (getrusage(who, &u) != 0) continue;
    for (const timeval& t : {u.ru_utime, u.ru_stime})
      sum += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  }
  return sum;
}

KernelCounts KernelCounts::now() {
  KernelCounts out;
  for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = counted(static_cast<Count>(i));
  return out;
}

void KernelCounts::add_since(const KernelCounts& before, std::vector<Figure>& figures) const {
  static const char* const names[] = {"exact_evaluations", "tested_pairs", "contacts",    "factorisations",
                                      "factor_nonzeros",   "touched_tets", "copied_bytes"};
  for (std::size_t i = 0; i < values.size(); ++i)
    if (const std::int64_t n = values[i] - before.values[i]; n > 0) figures.emplace_back(names[i], n);
}

void tell(const StageRecord& record, const RunContext& context) {
  if (!context.log) return;
  char text[64];
  const auto number = [&](const char* format, double x) {
    std::snprintf(text, sizeof text, format, x);
    return std::string(text);
  };
  std::string line = record.name + ": " + number("%.2f s", record.seconds);
  if (record.iterations > 0) line += ", " + std::to_string(record.iterations) + " iterations";
  for (const auto& [name, value] : record.figures) {
    line += ", " + name + " ";
    if (const auto* whole = std::get_if<std::int64_t>(&value)) line += std::to_string(*whole);
    if (const auto* real = std::get_if<double>(&value)) line += number("%.4g", *real);
    if (const auto* words = std::get_if<std::string>(&value)) line += *words;
    if (const auto* truth = std::get_if<bool>(&value)) line += *truth ? "yes" : "no";
  }
  context.note(LogLevel::info, line);
}

}  // namespace overtet
