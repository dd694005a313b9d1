// Ctrl-C and the other polite ways of ending a program, as a flag that the run looks at.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>

#include "overtet/result.h"

namespace overtet {

// Set by SIGINT, SIGTERM and SIGHUP once install_signal_handlers() was called. The program has three seconds
// from then on, whatever it is doing: then it is ended with exit code 130.
const std::atomic<bool>& interrupt_flag();
void install_signal_handlers();

// Ends the program where a run does not notice in time that it should stop (a long call into a library).
// Nothing is lost by that: outputs have no name before they are complete, child processes end with us.
class Watchdog {
 public:
  using Clock = std::chrono::steady_clock;
  // memory_limit: bytes of the whole process tree, 0: none. `late` is called once, just before _exit.
  Watchdog(Clock::time_point deadline, std::size_t memory_limit, std::function<void(const Error&)> late);
  ~Watchdog() { dismiss(); }
  void dismiss();  // from here on nothing is ended any more; waits for a `late` that has begun

 private:
  void watch();
  Clock::time_point deadline_;
  std::size_t memory_limit_;
  std::function<void(const Error&)> late_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool dismissed_ = false;
  std::thread thread_;
};

}  // namespace overtet
