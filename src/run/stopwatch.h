// Adds the seconds of wall time that it lives to a number.
#pragma once

#include <chrono>

#include "overtet/run_context.h"

namespace overtet {

class Stopwatch {
 public:
  explicit Stopwatch(double& into) : into_(into), start_(RunContext::Clock::now()) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() { into_ += std::chrono::duration<double>(RunContext::Clock::now() - start_).count(); }

 private:
  double& into_;
  RunContext::Clock::time_point start_;
};

}  // namespace overtet
