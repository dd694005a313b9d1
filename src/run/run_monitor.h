// Watches a run from a thread of its own: memory of the whole process tree, and the caller's wish to
// stop. The stages see both through RunContext::cancel.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>

#include "overtet/run_context.h"

namespace overtet {

class RunMonitor {
 public:
  // Starts watching. `outer.cancel` is followed; the limit is outer.memory_limit_bytes.
  explicit RunMonitor(const RunContext& outer);
  ~RunMonitor();
  RunMonitor(const RunMonitor&) = delete;
  RunMonitor& operator=(const RunMonitor&) = delete;

  // What stages get instead of the outer context.
  const RunContext& context() const { return inner_; }

  bool memory_exceeded() const { return memory_exceeded_; }
  std::size_t peak_bytes() const;  // largest of all samples, and of each process by itself

  // An "interrupted" that was really the memory limit becomes a limit error, and so does an allocation that
  // failed over it.
  Error explained(Error error) const;

 private:
  std::size_t look();  // what is in use
  void watch();

  RunContext inner_;
  const std::atomic<bool>* outer_cancel_;
  std::size_t limit_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> memory_exceeded_{false};
  std::atomic<std::size_t> peak_{0}, stage_peak_{0};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace overtet
