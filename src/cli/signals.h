// Ctrl-C and the other polite ways of ending a program, as a flag that the run looks at.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace overtet {

// Set by SIGINT, SIGTERM and SIGHUP once install_signal_handlers() was called.
const std::atomic<bool>& interrupt_flag();
void install_signal_handlers();

// Ends the program where a run does not notice in time that it should stop (a long call into a library).
// Nothing is lost by that: outputs have no name before they are complete, child processes end with us.
class Watchdog {
 public:
  using Clock = std::chrono::steady_clock;
  // `late` is called once, just before _exit, with the exit code (130 or 6).
  Watchdog(Clock::time_point deadline, std::function<void(int)> late);
  ~Watchdog() { dismiss(); }
  void dismiss();  // from here on nothing is ended any more; waits for a `late` that has begun

 private:
  void watch();
  Clock::time_point deadline_;
  std::function<void(int)> late_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool dismissed_ = false;
  std::thread thread_;
};

}  // namespace overtet
