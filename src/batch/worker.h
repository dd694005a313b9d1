// A process of its own for one model: started, watched and ended.
//
// It ends when the batch ends, however that happens (the kernel kills it with the thread that started it), it
// has no terminal, and what it prints is kept, the end of it, for messages.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "overtet/result.h"

namespace overtet {

struct WorkerEnd {
  std::optional<int> exit_code;  // none: a signal ended it
  int signal = 0;
  bool killed_late = false;  // by the batch, because it lived longer than it may
  double seconds = 0, cpu_seconds = 0;
  std::int64_t peak_rss_bytes = 0;  // of the process, and of its largest child
  std::string printed;              // the end of standard error
};

class Worker {
 public:
  using Clock = std::chrono::steady_clock;
  Worker() = default;
  Worker(Worker&& other) noexcept { swap(other); }
  Worker& operator=(Worker&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Worker();  // kills it

  // words[0]: the program. `latest`: when it is killed. Call it, and everything else, from one thread that
  // lives as long as the worker is to. Errors: internal (no process or pipe can be had).
  Status start(const std::vector<std::string>& words, Clock::time_point latest);

  pid_t id() const { return id_; }
  int process_fd() const { return process_; }  // readable when it has ended
  int printed_fd() const { return printed_; }  // readable when there is something to read; -1: no more
  void read_printed();                         // what is there, without waiting
  void interrupt();                            // asks it to end
  void kill();
  // How it ended, or none if it still runs. Kills it when its time has come.
  std::optional<WorkerEnd> ended();

 private:
  void swap(Worker& other) noexcept;

  pid_t id_ = -1;
  int process_ = -1, printed_ = -1;
  bool late_ = false;
  Clock::time_point start_{}, latest_ = Clock::time_point::max();
  std::string text_;
};

// Waits until a worker has ended or printed something, but no longer than `most`. Reads what they print.
void wait_for_any(std::vector<Worker*> workers, std::chrono::milliseconds most);

}  // namespace overtet
