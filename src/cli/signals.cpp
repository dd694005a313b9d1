#include "src/cli/signals.h"

#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "overtet/io.h"
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

// The memory limit, once allocations may have failed for it; 0: they have not.
std::atomic<std::size_t> braked_limit{0};

Error memory_error(std::size_t limit) {
  return {.code = ErrorCode::limit,
          .message = "The memory limit of " + std::to_string(limit >> 20) + " MiB was reached.",
          .reason = ErrorReason::memory_limit};
}

// Where somebody has begun to end the program: until when, as a count of the clock, and with which code.
std::atomic<bool> is_ending{false};
std::atomic<std::int64_t> end_by{std::numeric_limits<std::int64_t>::max()};
std::atomic<int> end_with{0};

// Ends the program whatever state it is in: a watchdog, too, may wait for who is blocked in a write to a pipe
// that is not read. Takes no locks that others hold for long, waits for nobody.
void end_when_stuck() {
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> since;
  for (;; std::this_thread::sleep_for(kWatchPeriod)) {
    if (Clock::now().time_since_epoch().count() > end_by.load(std::memory_order_acquire))
      end_at_once(end_with.load(std::memory_order_relaxed));
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

// What this process has mapped to write to, in use or not: what RLIMIT_DATA bounds.
std::size_t mapped_data() {
  std::ifstream pages("/proc/self/statm");
  std::size_t total, resident, shared, text, library, data;
  return pages >> total >> resident >> shared >> text >> library >> data
             ? data * static_cast<std::size_t>(sysconf(_SC_PAGESIZE))
             : 0;
}

std::size_t peak_of_this_process() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

// Those of every thread of this process; they die with it, but not before.
void kill_children() {
  for (const auto& task : std::filesystem::directory_iterator(
           "/proc/self/task", std::filesystem::directory_options::skip_permission_denied)) {
    std::ifstream children(task.path() / "children");
    for (pid_t child; children >> child;) ::kill(child, SIGKILL);
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

void begin_to_end(int code) {
  if (is_ending.exchange(true))
    for (;;) ::pause();
  end_with = code;
  end_by.store((std::chrono::steady_clock::now() + kLateTime).time_since_epoch().count(),
               std::memory_order_release);
}

void end_at_once(int code) {
  try {
    remove_unfinished_files();
  } catch (...) {  // for want of memory
  }
  _exit(code);
}

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
  // (std::call_once aborts where starting the thread throws.)
  static std::atomic_flag started = ATOMIC_FLAG_INIT;
  if (!started.test_and_set()) quiet_thread(end_when_stuck).detach();
}

Error explained(Error error) {
  const bool short_of_memory = error.code == ErrorCode::limit && error.reason == ErrorReason::none;
  const std::size_t limit = braked_limit;
  return short_of_memory && limit > 0 ? memory_error(limit) : error;
}

bool has_met_memory_limit() { return braked_limit > 0; }

Watchdog::Watchdog(const RunContext& context, Clock::time_point start, std::function<void(const Error&)> late)
    : deadline_(context.deadline), memory_limit_(context.memory_limit_bytes), late_(std::move(late)) {
  if (deadline_ != Clock::time_point::max()) {
    const auto limit = std::chrono::duration<double>(std::max(deadline_ - start, Clock::duration(0)));
    grace_ = std::chrono::duration_cast<Clock::duration>(
        std::min<std::chrono::duration<double>>(kTimeOver * limit, kMostTimeOver));
  }
  thread_ = quiet_thread([this] { watch(); });
}

Watchdog::~Watchdog() {
  (void)leave(State::finished);
  {
    const std::lock_guard lock(mutex_);
    dismissed_ = true;
  }
  wake_.notify_all();
  thread_.join();
  brake(0);
}

bool Watchdog::leave(State to) {
  State state = State::running;
  if (state_.compare_exchange_strong(state, to)) return true;
  while (state == State::ending) ::pause();  // another thread is ending the program
  return false;
}

bool Watchdog::finish() {
  if (state_ == State::finished) return true;
  if (interrupted || Clock::now() >= deadline_) return false;
  // What came and went between two looks.
  if (memory_limit_ > 0 && peak_of_this_process() > most_memory()) {
    end(memory_error(memory_limit_));
    (void)leave(State::finished);
  }
  (void)leave(State::finished);
  return state_ == State::finished;
}

void Watchdog::settle(ErrorCode code) {
  settled_ = exit_code(code);
  settled_at_ = Clock::now().time_since_epoch().count();
  (void)leave(State::settled);
}

RunContext Watchdog::writing(RunContext context) {
  context.may_name = [this] { return finish(); };
  return context;
}

void Watchdog::end(const Error& error) {
  State state = State::running;
  if (!state_.compare_exchange_strong(state, State::ending)) return;
  const int code = exit_code(error.code);
  begin_to_end(code);
  if (error.reason == ErrorReason::memory_limit) kill_children();
  try {
    late_(error);
  } catch (...) {  // for want of memory: the exit code says enough
  }
  end_at_once(code);
}

// More is in use than allowed, for a while or by too much.
bool Watchdog::is_full(std::size_t used) {
  if (memory_limit_ == 0 || used <= memory_limit_) {
    full_since_ = Clock::time_point::max();
    return false;
  }
  if (full_since_ == Clock::time_point::max()) full_since_ = Clock::now();
  return used > most_memory() || Clock::now() - full_since_ > kGrace;
}

// Near the limit nothing is mapped any more that would break it once it is in use: allocations fail instead.
// A look comes too late for what is taken in one go.
void Watchdog::brake(std::size_t used) {
  const bool near = memory_limit_ > 0 && used > memory_limit_ - 2 * (memory_limit_ / kMemoryOver);
  if (!near && !braked_) return;
  rlimit data{};
  if (getrlimit(RLIMIT_DATA, &data) != 0) return;
  if (!braked_) unbraked_ = data.rlim_cur;
  braked_ = near;
  if (near) braked_limit = memory_limit_;
  const rlim_t most =
      mapped_data() + (most_memory() - std::min(used, most_memory())) + memory_limit_ / kMemoryOver;
  data.rlim_cur = near ? std::min(most, unbraked_) : unbraked_;
  (void)::setrlimit(RLIMIT_DATA, &data);
}

void Watchdog::watch() {
  std::unique_lock lock(mutex_);
  auto interrupted_at = Clock::time_point::max();
  const auto longer = [](Clock::time_point since, Clock::duration grace) {
    return since != Clock::time_point::max() && Clock::now() > since && Clock::now() - since > grace;
  };
  std::size_t used = 0;
  // Nothing is ended before some time has passed, so there is nothing to look at in the beginning.
  const auto pause = [&] {
    Clock::duration next = kWatchPeriod;
    if (memory_limit_ > 0)
      next = std::min<Clock::duration>(next, look_again_after(most_memory() - std::min(used, most_memory())));
    if (deadline_ != Clock::time_point::max())
      next = std::min(
          next, std::max<Clock::duration>(deadline_ - Clock::now() + grace_, std::chrono::milliseconds(1)));
    return next;
  };
  while (!wake_.wait_for(lock, pause(), [this] { return dismissed_; })) {
    if (state_ == State::settled && longer(deadline_, grace_ + grace_ / 2) &&
        longer(Clock::time_point(Clock::duration(settled_at_)), kLateTime))
      end_at_once(settled_);
    if (state_ == State::finished) brake(0);  // what is written is to be told
    if (state_ != State::running) continue;
    if (!interrupted)
      interrupted_at = Clock::time_point::max();
    else if (interrupted_at == Clock::time_point::max())
      interrupted_at = Clock::now();
    used = memory_limit_ > 0 ? tree_resident_bytes() : 0;
    brake(used);
    if (longer(interrupted_at, kGrace))
      end({ErrorCode::interrupted, "Interrupted; nothing was written."});
    else if (longer(deadline_, grace_))
      end({.code = ErrorCode::limit,
           .message = "The time limit was reached.",
           .reason = ErrorReason::time_limit});
    else if (is_full(used))
      end(memory_error(memory_limit_));
  }
}

}  // namespace overtet
