// Runs one stage and writes down what it took. Internal to src/pipeline.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/parallel/counts.h"
#include "overtet/report.h"
#include "overtet/run_context.h"

namespace overtet {

double cpu_seconds();  // of this process and its children that have ended

// What the kernels have counted so far, and what of it is new since then, as figures.
struct KernelCounts {
  std::array<std::int64_t, static_cast<std::size_t>(Count::end)> values{};
  static KernelCounts now();
  void add_since(const KernelCounts& before, std::vector<Figure>& figures) const;
};

// Tells what a stage took and found, on one line.
void tell(const StageRecord& record, const RunContext& context);

// f(record) returns a Result. A stage that is tried twice leaves two records.
template <class F>
auto timed_stage(const char* name, std::vector<StageRecord>& records, const RunContext& context, F&& f) {
  context.report(name, 0);
  const auto start = RunContext::Clock::now();
  const double cpu = cpu_seconds();
  const KernelCounts counts = KernelCounts::now();
  if (context.stage_peak_bytes) *context.stage_peak_bytes = 0;
  StageRecord record;
  record.name = name;
  auto outcome = f(record);
  record.seconds = std::chrono::duration<double>(RunContext::Clock::now() - start).count();
  record.cpu_seconds = cpu_seconds() - cpu;
  KernelCounts::now().add_since(counts, record.figures);
  // Stages that end before the first look at the memory have none.
  if (context.stage_peak_bytes && *context.stage_peak_bytes > 0)
    record.figures.emplace_back("peak_rss_bytes", static_cast<std::int64_t>(*context.stage_peak_bytes));
  if (!outcome.ok()) record.figures.emplace_back("error", outcome.error().message);
  tell(record, context);
  records.push_back(std::move(record));
  return outcome;
}

}  // namespace overtet
