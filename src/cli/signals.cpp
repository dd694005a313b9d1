#include "src/cli/signals.h"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "overtet/io.h"
#include "overtet/run_context.h"
#include "src/cli/tuning.h"

namespace overtet {

namespace {

std::atomic<bool> interrupted{false};
std::atomic<int> last_signal{SIGINT};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler sets them");

extern "C" void on_signal(int signal) {
  last_signal.store(signal, std::memory_order_relaxed);
  interrupted.store(true, std::memory_order_release);
}

[[noreturn]] void end_at_once(int code) {
  remove_unfinished_files();
  _exit(code);
}

// Ends the program whatever state it is in. Takes no locks that others hold for long, waits for nobody.
void end_when_stuck() {
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> since;
  for (;; std::this_thread::sleep_for(kWatchPeriod)) {
    if (!interrupted) continue;
    if (!since) since = Clock::now();
    if (Clock::now() - *since <= kLastGrace) continue;
    constexpr std::string_view words = "overtet: Interrupted.\n";
    pollfd error{STDERR_FILENO, POLLOUT, 0};
    if (poll(&error, 1, 0) == 1 && (error.revents & POLLOUT) != 0)
      (void)!::write(STDERR_FILENO, words.data(), words.size());
    end_at_once(exit_code(ErrorCode::interrupted));
  }
}

// A thread that no signal is delivered to.
template <class F>
std::thread quiet_thread(F&& f) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread(std::forward<F>(f));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

}  // namespace

const std::atomic<bool>& interrupt_flag() { return interrupted; }

int exit_code(ErrorCode code) {
  return code == ErrorCode::interrupted ? 128 + last_signal.load(std::memory_order_relaxed)
                                        : static_cast<int>(code);
}

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    // Whoever started us with nohup wants us to outlive the terminal.
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
  // Writing to a closed pipe, and more than `ulimit -f` allows, are errors like others.
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);
  static std::once_flag once;
  std::call_once(once, [] { quiet_thread(end_when_stuck).detach(); });
}

Watchdog::Watchdog(Clock::time_point deadline, std::size_t memory_limit,
                   std::function<void(const Error&)> late)
    : deadline_(deadline), memory_limit_(memory_limit), late_(std::move(late)) {
  thread_ = quiet_thread([this] { watch(); });
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
  auto interrupted_at = Clock::time_point::max(), full_at = Clock::time_point::max();
  const auto longer = [](Clock::time_point since, Clock::duration grace) {
    return since != Clock::time_point::max() && Clock::now() > since && Clock::now() - since > grace;
  };
  // Nothing is ended before some time has passed, so there is nothing to look at in the beginning.
  while (!wake_.wait_for(lock, kWatchPeriod, [this] { return dismissed_; })) {
    if (!interrupted)
      interrupted_at = Clock::time_point::max();
    else if (interrupted_at == Clock::time_point::max())
      interrupted_at = Clock::now();
    if (memory_limit_ == 0 || tree_resident_bytes() <= memory_limit_)
      full_at = Clock::time_point::max();
    else if (full_at == Clock::time_point::max())
      full_at = Clock::now();

    std::optional<Error> end;
    if (longer(interrupted_at, kGrace))
      end = Error{ErrorCode::interrupted, "Interrupted; nothing was written."};
    else if (longer(deadline_, kLastGrace))
      end = Error{.code = ErrorCode::limit,
                  .message = "The time limit was reached.",
                  .reason = ErrorReason::time_limit};
    else if (longer(full_at, kGrace))
      end =
          Error{.code = ErrorCode::limit,
                .message = "The memory limit of " + std::to_string(memory_limit_ >> 20) + " MiB was reached.",
                .reason = ErrorReason::memory_limit};
    if (end) {
      late_(*end);
      end_at_once(exit_code(end->code));
    }
  }
}

}  // namespace overtet
