// Which stages a run has gone through, as its progress tells: for the report of a run that is ended from
// outside, whose own records are lost with it.
#pragma once

#include <chrono>
#include <ctime>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "overtet/report.h"
#include "overtet/run_context.h"

namespace overtet {

class StageTrail {
 public:
  // The context, but its progress is followed. The trail must outlive it.
  RunContext follow(RunContext context);
  // The last one until now.
  std::vector<StageRecord> records() const;

 private:
  using Clock = std::chrono::steady_clock;
  struct Step {
    std::string name;
    Clock::time_point begin;
    std::clock_t cpu;
  };
  void enter(std::string_view stage);

  mutable std::mutex mutex_;
  std::vector<Step> steps_;
};

}  // namespace overtet
