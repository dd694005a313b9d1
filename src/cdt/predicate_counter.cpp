#include "src/cdt/predicate_counter.h"

#include <dlfcn.h>
#include <signal.h>
#include <sys/time.h>
#include <tetgen.h>

#include <atomic>
#include <limits>

namespace overtet::predicate_watch {

namespace {

// TetGen works on one thread, and so does the handler: relaxed order is an ordinary addition.
std::atomic<std::int64_t> count{0};
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

std::int64_t most_calls = std::numeric_limits<std::int64_t>::max();
std::int64_t count_before = -1;
int idle = 0, most_idle = 0;
void (*out)() = nullptr;

void tick(int) {
  const std::int64_t now = count.load(std::memory_order_relaxed);
  idle = now == count_before ? idle + 1 : 0;
  count_before = now;
  if (idle >= most_idle) out();
}

void count_one() {
  const std::int64_t now = count.load(std::memory_order_relaxed) + 1;
  count.store(now, std::memory_order_relaxed);
  if (now > most_calls) out();
}

// The library's own function of that (mangled) name.
template <class Function>
Function* next_of(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

void begin(std::int64_t most, int idle_seconds, void (*give_up)()) {
  most_calls = calls() + most;
  most_idle = idle_seconds;
  out = give_up;
  struct sigaction action {};
  action.sa_handler = tick;
  action.sa_flags = SA_RESTART;
  sigaction(SIGVTALRM, &action, nullptr);
  const itimerval each_second{{1, 0}, {1, 0}};
  setitimer(ITIMER_VIRTUAL, &each_second, nullptr);
}

void end() {
  most_calls = std::numeric_limits<std::int64_t>::max();
  const itimerval never{};
  setitimer(ITIMER_VIRTUAL, &never, nullptr);
}

std::int64_t calls() { return count.load(std::memory_order_relaxed); }

}  // namespace overtet::predicate_watch

using overtet::predicate_watch::count_one;
using overtet::predicate_watch::next_of;

REAL orient3d(REAL* a, REAL* b, REAL* c, REAL* d) {
  static auto* const next = next_of<REAL(REAL*, REAL*, REAL*, REAL*)>("_Z8orient3dPdS_S_S_");
  count_one();
  return next(a, b, c, d);
}

REAL insphere(REAL* a, REAL* b, REAL* c, REAL* d, REAL* e) {
  static auto* const next = next_of<REAL(REAL*, REAL*, REAL*, REAL*, REAL*)>("_Z8inspherePdS_S_S_S_");
  count_one();
  return next(a, b, c, d, e);
}
