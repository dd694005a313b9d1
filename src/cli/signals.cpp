#include "src/cli/signals.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>

#include "overtet/result.h"

namespace overtet {

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

extern "C" void on_signal(int) { interrupted.store(true, std::memory_order_relaxed); }

// How long a run may take to notice.
constexpr auto kInterruptGrace = std::chrono::milliseconds(1500);
constexpr auto kDeadlineGrace = std::chrono::milliseconds(2500);
constexpr auto kPeriod = std::chrono::milliseconds(50);

}  // namespace

const std::atomic<bool>& interrupt_flag() { return interrupted; }

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaction(signal, &action, nullptr);
  // Writing to a closed pipe is an error like others.
  ::signal(SIGPIPE, SIG_IGN);
}

Watchdog::Watchdog(Clock::time_point deadline, std::function<void(int)> late)
    : deadline_(deadline), late_(std::move(late)) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { watch(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void Watchdog::dismiss() {
  {
    const std::lock_guard lock(mutex_);
    dismissed_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Watchdog::watch() {
  std::unique_lock lock(mutex_);
  auto interrupted_at = Clock::time_point::max();
  while (!dismissed_) {
    const auto now = Clock::now();
    if (interrupted && interrupted_at == Clock::time_point::max()) interrupted_at = now;
    const bool too_long =
        interrupted_at != Clock::time_point::max() && now - interrupted_at > kInterruptGrace;
    const bool too_late =
        deadline_ != Clock::time_point::max() && now > deadline_ && now - deadline_ > kDeadlineGrace;
    if (too_long || too_late) {
      const int code = static_cast<int>(too_long ? ErrorCode::interrupted : ErrorCode::limit);
      late_(code);
      _exit(code);
    }
    wake_.wait_for(lock, kPeriod);
  }
}

}  // namespace overtet
