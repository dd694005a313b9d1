#include "kernels/parallel/counts.h"

#include <atomic>
#include <deque>
#include <mutex>
#include <vector>

namespace overtet {

namespace {

struct alignas(64) Counters {
  std::atomic<std::int64_t> value[static_cast<std::size_t>(Count::end)] = {};  // written by one thread only
};

// Counters are never given back, only passed on to threads that start later.
struct Registry {
  std::mutex mutex;
  std::deque<Counters> all;
  std::vector<Counters*> unused;
};
// Made before any thread starts, and never destroyed: threads may end after everything else.
Registry& registry = *new Registry;

struct Mine {
  Mine() {
    const std::lock_guard lock(registry.mutex);
    if (registry.unused.empty()) {
      counters = &registry.all.emplace_back();
    } else {
      counters = registry.unused.back();
      registry.unused.pop_back();
    }
  }
  ~Mine() {
    const std::lock_guard lock(registry.mutex);
    registry.unused.push_back(counters);
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
  const std::lock_guard lock(registry.mutex);
  std::int64_t sum = 0;
  for (const Counters& c : registry.all)
    sum += c.value[static_cast<int>(what)].load(std::memory_order_relaxed);
  return sum;
}

}  // namespace overtet
