// What a function needs to know about the run it is part of: when to stop, how many threads to use, whom to
// tell. A default RunContext has no limits, uses all cores and tells nobody. The library itself never prints,
// never exits and installs no signal handler.
//
// A context is read by many threads while a run lasts; it and what it points to must stay as they are until
// the call returns (`*cancel` may be set at any time). The functions in it may be called from several
// threads at once, also from others than the one that called the library; they should return quickly and
// must not throw.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "overtet/result.h"

namespace overtet {

enum class LogLevel { error, warning, info, debug };

struct RunContext {
  using Clock = std::chrono::steady_clock;

  const std::atomic<bool>* cancel = nullptr;              // set by the caller to stop the run
  Clock::time_point deadline = Clock::time_point::max();  // wall-clock
  std::size_t memory_limit_bytes = 0;                     // of the whole process tree; 0: none
  int threads = 0;                                        // 0: all cores; results do not depend on it
  // Where whoever watches the run keeps the most memory that was in use since a stage began. Null: nobody
  // does.
  std::atomic<std::size_t>* stage_peak_bytes = nullptr;
  // Asked by whoever writes a file once that is complete on the disk, before it gets its name; false: it gets
  // none, and writing it is an error. Null: it always gets its name.
  std::function<bool()> may_name;
  // The program overtet-tetgen, which runs TetGen in a process of its own. Empty: beside the running program,
  // else where this installation has it.
  std::string tetgen_helper;
  // stage: for instance "improve"; fraction of it that is done, 0 to 1; detail: a few words, may be empty.
  std::function<void(std::string_view stage, double fraction, std::string_view detail)> progress;
  std::function<void(LogLevel, std::string_view)> log;

  // Why the run must stop now, if it must: interrupted or limit. Cheap; call it in every outer loop.
  std::optional<Error> stop() const;

  // Why a file that is complete must not get its name, if it must not: stop(), or may_name says so.
  std::optional<Error> no_name() const;

  // Why `bytes` more cannot be taken, if they cannot. Call before every large allocation.
  std::optional<Error> no_room_for(std::size_t bytes) const;

  // Seconds until the deadline (a large number when there is none, never negative).
  double seconds_left() const;

  void report(std::string_view stage, double fraction, std::string_view detail = {}) const {
    if (progress) progress(stage, fraction, detail);
  }
  void note(LogLevel level, std::string_view message) const {
    if (log) log(level, message);
  }
};

// Resident memory of this process and its descendants: what memory_limit_bytes is compared with.
std::size_t tree_resident_bytes();

// How soon to look again at what is in use where that may grow by so many bytes: sooner than it can.
std::chrono::microseconds look_again_after(std::size_t bytes);

// What a process may use before the machine swaps or kills it, in bytes: the memory in use now and what
// is free (/proc/meminfo), or what its control group or Slurm (SLURM_MEM_PER_NODE, SLURM_MEM_PER_CPU) allows
// if that is less. 0 where that is not known.
std::size_t usable_memory_bytes();

// How many threads can run at once: the cores that the process may use (its affinity), or what the CPU quota
// of its control group or Slurm (SLURM_CPUS_PER_TASK) allows if that is less; at least 1. Parts of a core
// that a quota allows do not count.
int usable_cores();

}  // namespace overtet
