#include "src/cli/stage_trail.h"

#include <algorithm>
#include <utility>

namespace overtet {

RunContext StageTrail::follow(RunContext context) {
  context.progress = [this, progress = std::move(context.progress)](std::string_view stage, double fraction,
                                                                    std::string_view detail) {
    enter(stage);
    if (progress) progress(stage, fraction, detail);
  };
  return context;
}

void StageTrail::enter(std::string_view stage) {
  const std::lock_guard lock(mutex_);
  if (steps_.empty() || steps_.back().name != stage)
    steps_.push_back({std::string(stage), Clock::now(), std::clock()});
}

std::vector<StageRecord> StageTrail::records() const {
  const std::lock_guard lock(mutex_);
  std::vector<StageRecord> records;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const bool last = i + 1 == steps_.size();
    const Clock::time_point end = last ? Clock::now() : steps_[i + 1].begin;
    const std::clock_t cpu = last ? std::clock() : steps_[i + 1].cpu;
    StageRecord& record = records.emplace_back();
    record.name = steps_[i].name;
    std::replace(record.name.begin(), record.name.end(), '-', '_');
    record.seconds = std::chrono::duration<double>(end - steps_[i].begin).count();
    record.cpu_seconds = static_cast<double>(cpu - steps_[i].cpu) / CLOCKS_PER_SEC;
  }
  return records;
}

}  // namespace overtet
