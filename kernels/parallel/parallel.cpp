#include "kernels/parallel/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <mutex>
#include <optional>
#include <utility>

// The thread sanitizer does not see how TBB, which is not built with it, hands blocks to threads and waits
// for them; this file is therefore compiled without it too (see CMakeLists.txt), and two tokens tell it what
// matters: what the caller did comes before every block, and every block before what the caller does next.
// Blocks are not ordered among each other, so races between them are still found.
#if defined(OVERTET_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#define OVERTET_HAPPENS_BEFORE(token) __tsan_release(token)
#define OVERTET_HAPPENS_AFTER(token) __tsan_acquire(token)
// What TBB frees on its own threads it has ordered by means that cannot be seen either.
extern "C" const char* __tsan_default_suppressions() { return "called_from_lib:libtbb.so\n"; }
#else
#define OVERTET_HAPPENS_BEFORE(token) static_cast<void>(token)
#define OVERTET_HAPPENS_AFTER(token) static_cast<void>(token)
#endif

namespace overtet {

namespace {

struct Pool {
  explicit Pool(int threads) : count(threads > 0 ? threads : tbb::info::default_concurrency()), arena(count) {
    // More threads than cores are never useful, but tests ask for them to provoke other schedules.
    if (count > tbb::info::default_concurrency())
      allow.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
  }
  int count;
  std::optional<tbb::global_control> allow;
  tbb::task_arena arena;
};

std::mutex default_mutex;
std::shared_ptr<Pool> default_pool;

thread_local std::shared_ptr<void> scoped_pool;
thread_local int depth = 0;       // > 0: this thread is running a block, so it already is in the right arena
thread_local bool alone = false;  // it is the only thread of its pool, and in no arena

std::shared_ptr<Pool> current_pool() {
  if (scoped_pool) return std::static_pointer_cast<Pool>(scoped_pool);
  const std::lock_guard lock(default_mutex);
  if (!default_pool) default_pool = std::make_shared<Pool>(0);
  return default_pool;
}

struct Inside {
  Inside() { ++depth; }
  ~Inside() { --depth; }
};

struct Alone {
  Alone() : before(std::exchange(alone, true)) {}
  ~Alone() { alone = before; }
  bool before;
};

}  // namespace

void set_thread_cap(int threads) {
  auto pool = std::make_shared<Pool>(threads);
  const std::lock_guard lock(default_mutex);
  default_pool = std::move(pool);
}

int thread_cap() {
  if (alone) return 1;
  if (depth > 0) return tbb::this_task_arena::max_concurrency();
  return current_pool()->count;
}

ScopedThreads::ScopedThreads(int threads) : previous_(scoped_pool) {
  const int count = threads > 0 ? threads : tbb::info::default_concurrency();
  if (!previous_ || std::static_pointer_cast<Pool>(previous_)->count != count)
    scoped_pool = std::make_shared<Pool>(threads);
}

ScopedThreads::~ScopedThreads() { scoped_pool = std::move(previous_); }

namespace parallel_detail {

void run_blocks(std::int64_t blocks, void* context, void (*run)(void*, std::int64_t)) {
  if (alone) {
    for (std::int64_t i = 0; i < blocks; ++i) run(context, i);
    return;
  }
  char begun = 0, ended = 0;  // only their addresses count
  OVERTET_HAPPENS_BEFORE(&begun);
  const auto loop = [&] {
    tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, blocks),
                      [&](const tbb::blocked_range<std::int64_t>& range) {
                        const Inside inside;
                        OVERTET_HAPPENS_AFTER(&begun);
                        for (std::int64_t i = range.begin(); i != range.end(); ++i) run(context, i);
                        OVERTET_HAPPENS_BEFORE(&ended);
                      });
  };
  if (depth > 0) {
    // Nested: isolated, so that a thread that waits here does not start an unrelated outer block on
    // top of its stack (which would see this thread's half-finished thread-local state).
    tbb::this_task_arena::isolate(loop);
    OVERTET_HAPPENS_AFTER(&ended);
    return;
  }
  const std::shared_ptr<Pool> pool = current_pool();
  if (pool->count == 1) {
    const Alone one;
    for (std::int64_t i = 0; i < blocks; ++i) run(context, i);
    return;
  }
  pool->arena.execute(loop);
  OVERTET_HAPPENS_AFTER(&ended);
}

}  // namespace parallel_detail

}  // namespace overtet
