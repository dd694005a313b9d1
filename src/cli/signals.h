// Ctrl-C and the other polite ways of ending a program, as a flag that the run looks at.
#pragma once

#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/cli/tuning.h"

namespace overtet {

// Set by SIGINT, SIGTERM and SIGHUP (unless that was ignored before, as nohup does) once
// install_signal_handlers() was called. The program has less than two seconds from then on, whatever it is
// doing: then it is ended.
const std::atomic<bool>& interrupt_flag();
void install_signal_handlers();

// What the program ends with: as shells say it, 128 and the number of the signal where one has interrupted it
// (130 SIGINT, 143 SIGTERM, 129 SIGHUP); else the code's own number.
int exit_code(ErrorCode code);

// An allocation that failed near the memory limit did so for that.
Error explained(Error error);
bool has_met_memory_limit();

// The thread that calls this ends the program soon, and says why: nobody else does, and any other thread that
// calls this waits for the end. If saying it takes too long, the program ends without.
void begin_to_end(int code);

// Ends the program now; removes what it has not finished writing.
[[noreturn]] void end_at_once(int code);

// Ends the program where a run does not notice in time that it should stop (a long call into a library, a
// write to a slow disk): so that time and memory stay within a few per cent of their limits, and signals end
// it soon. Nothing is lost by that: outputs have no name before they are complete, child processes end with
// us. It holds from its making to the moment when the first output gets its name, or until it is destroyed.
// More than 12 members: what it watches, since when, and how that ends.
class Watchdog {
 public:
  using Clock = std::chrono::steady_clock;
  // start: from when on the time counts. `late` is called once, just before the program ends.
  Watchdog(const RunContext& context, Clock::time_point start, std::function<void(const Error&)> late);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  // The same, for who writes the outputs: they get their names unless the time is up or somebody interrupts.
  RunContext writing(RunContext context);
  // The run has failed, and what is to be said and reported of that follows: no message of ours any more, and
  // the code with which the program ends if that takes too long.
  void settle(ErrorCode code);

 private:
  enum class State { running, ending, settled, finished };
  bool leave(State to);  // never returns where the program is being ended
  bool finish();         // from here on nothing is ended any more, unless that is too late
  void end(const Error& error);
  bool is_full(std::size_t used);
  void brake(std::size_t used);
  std::size_t most_memory() const { return memory_limit_ + memory_limit_ / kMemoryOver; }
  void watch();

  Clock::time_point deadline_;
  Clock::duration grace_{0};
  std::size_t memory_limit_;
  std::function<void(const Error&)> late_;
  std::atomic<State> state_{State::running};
  std::atomic<int> settled_{0};
  std::atomic<Clock::rep> settled_at_{0};
  Clock::time_point full_since_ = Clock::time_point::max();
  bool braked_ = false;
  rlim_t unbraked_ = 0;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool dismissed_ = false;
  std::thread thread_;
};

}  // namespace overtet
