// How far the quality pass is, while parts of the mesh are worked on at the same time.
#pragma once

#include <algorithm>
#include <atomic>
#include <string>
#include <string_view>

#include "overtet/run_context.h"

namespace overtet {

// Tells a context shares of the stage that only grow. part_ended() and within() may be called from several
// threads.
class RoundProgress {
 public:
  explicit RoundProgress(const RunContext& context) : context_(context) {}

  // A round of so many parts, which takes the stage from one share to another.
  void begin(double from, double to, int parts, const std::string& detail) {
    from_ = std::max(from, told_.load());
    to_ = std::max(to, from_);
    parts_ = std::max(parts, 1);
    ended_ = 0;
    tell(from_, detail);
  }
  void part_ended() { tell(from_ + (to_ - from_) * ++ended_ / parts_, {}); }
  // What one of the parts says of its own work: the others may be as far.
  void within(double fraction, std::string_view detail) {
    tell(from_ + (to_ - from_) * std::min(1.0, (ended_ + std::clamp(fraction, 0.0, 1.0)) / parts_), detail);
  }

 private:
  void tell(double share, std::string_view detail) {
    double before = told_.load();
    while (share > before && !told_.compare_exchange_weak(before, share)) {
    }
    context_.report("improve", std::max(share, before), detail);
  }

  const RunContext& context_;
  double from_ = 0, to_ = 0;
  int parts_ = 1;
  std::atomic<int> ended_{0};
  std::atomic<double> told_{0};
};

}  // namespace overtet
