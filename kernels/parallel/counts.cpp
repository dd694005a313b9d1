#include "kernels/parallel/counts.h"

#include <atomic>
#include <deque>
#include <mutex>
#include <vector>

namespace overtet {

namespace {

struct alignas(64) Counters {
  std::atomic<std::int64_t> value[kCounts] = {};  // written by one thread only
};

// Counters are never given back, only passed on to threads that start later. Lives as long as the process:
// threads may end after everything else.
struct Registry {
  std::mutex mutex;
  std::deque<Counters> all;
  std::vector<Counters*> unused;
};
Registry& registry() {
  static Registry* const r = new Registry;
  return *r;
}

struct Mine {
  Mine() {
    Registry& r = registry();
    const std::lock_guard lock(r.mutex);
    if (r.unused.empty()) {
      counters = &r.all.emplace_back();
    } else {
      counters = r.unused.back();
      r.unused.pop_back();
    }
  }
  ~Mine() {
    Registry& r = registry();
    const std::lock_guard lock(r.mutex);
    r.unused.push_back(counters);
  }
  Counters* counters;
};

}  // namespace

void count(Count what, std::int64_t n) {
  thread_local const Mine mine;
  auto& value = mine.counters->value[static_cast<int>(what)];
  value.store(value.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
}

std::int64_t counted(Count what) {
  Registry& r = registry();
  const std::lock_guard lock(r.mutex);
  std::int64_t sum = 0;
  for (const Counters& c : r.all) sum += c.value[static_cast<int>(what)].load(std::memory_order_relaxed);
  return sum;
}

}  // namespace overtet
