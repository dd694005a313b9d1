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

// Set by SIGINT, SIGTERM and SIGHUP (unless that was ignored before, as nohup does) once
// install_signal_handlers() was called. The program has less than two seconds from then on, whatever it is
// doing: then it is ended.
const std::atomic<bool>& interrupt_flag();
void install_signal_handlers();

// What the program ends with: as shells say it, 128 and the number of the signal where one has interrupted it
// (130 SIGINT, 143 SIGTERM, 129 SIGHUP); else the code's own number.
int exit_code(ErrorCode code);

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
