// Loops on all cores whose results do not depend on the number of threads. The only room that names TBB.
//
// Why the results do not depend on the number of threads
//
// A loop over 0 .. n-1 is cut into blocks [0, g), [g, 2g), ... where g is the *grain* the caller passes.
// The cut depends on n and g only: not on the number of threads, not on which thread is idle, not on
// whether the loop is nested inside another one. The scheduler decides only who runs a block and when.
// From this three facts follow:
//
//  1. parallel_for: a body that writes only to places owned by its own indices, and reads only what no
//     other block writes, gives the same bytes in every schedule. There is nothing else to agree on.
//  2. parallel_reduce: every block is folded from its first index to its last into its own slot, and the
//     slots are folded from the first block to the last by one thread. Floating-point addition is not
//     associative, but the bracketing of the sum is a function of (n, g) alone, so its rounding is too.
//     Changing the grain changes the last bits; grains are therefore constants next to the loop, never
//     computed from the thread count.
//  3. parallel_collect: every block appends to its own list; the lists are joined in block order. The
//     result is what one thread would have written, whoever finished first.
//
// What a caller must not do: add to a shared double from several blocks (atomics on doubles bring the
// schedule back in), merge per-thread lists in arrival order, draw random numbers from a shared state.
//
// Short loops (n <= grain) run at once in the calling thread: the sequential threshold is the grain.
// Loops may be nested and may be called from several threads. An exception thrown by a body leaves the
// loop after the blocks already running have ended.
//
// How many threads: ScopedThreads wins over set_thread_cap, which wins over "all cores".
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace overtet {

// The process-wide number of threads for loops started from now on; 0: all cores.
void set_thread_cap(int threads);

// The number of threads a loop started here may use.
int thread_cap();

// Loops started by this thread while the object lives (and loops nested in them) use at most `threads`
// threads, 0: all cores. Not to be moved between threads; scopes nest.
class ScopedThreads {
 public:
  explicit ScopedThreads(int threads);
  ~ScopedThreads();
  ScopedThreads(const ScopedThreads&) = delete;
  ScopedThreads& operator=(const ScopedThreads&) = delete;

 private:
  std::shared_ptr<void> previous_;
};

namespace parallel_detail {
// Calls run(context, i) for every i in 0 .. blocks-1, on all threads of the current arena.
void run_blocks(std::int64_t blocks, void* context, void (*run)(void*, std::int64_t));
}  // namespace parallel_detail

// f(begin, end) for every block of `grain` consecutive indices of 0 .. n-1.
template <class F>
void parallel_for(std::int64_t n, std::int64_t grain, F&& f) {
  if (n <= 0) return;
  grain = std::max<std::int64_t>(grain, 1);
  if (n <= grain) {
    f(std::int64_t{0}, n);
    return;
  }
  struct Context {
    std::remove_reference_t<F>* f;
    std::int64_t n, grain;
  } context{&f, n, grain};
  parallel_detail::run_blocks((n + grain - 1) / grain, &context, [](void* p, std::int64_t block) {
    const Context& c = *static_cast<Context*>(p);
    const std::int64_t begin = block * c.grain;
    (*c.f)(begin, std::min(begin + c.grain, c.n));
  });
}

// combine(... combine(combine(identity, map(0, g)), map(g, 2g)) ...): blocks in order, always bracketed
// the same way. map(begin, end) returns a T.
template <class T, class Map, class Combine>
T parallel_reduce(std::int64_t n, std::int64_t grain, T identity, Map&& map, Combine&& combine) {
  if (n <= 0) return identity;
  grain = std::max<std::int64_t>(grain, 1);
  if (n <= grain) return combine(std::move(identity), map(std::int64_t{0}, n));
  // Wrapped, so that T = bool does not become a bit field that two threads write.
  struct Slot {
    T value;
  };
  std::vector<Slot> slots(static_cast<std::size_t>((n + grain - 1) / grain), Slot{identity});
  parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    slots[static_cast<std::size_t>(begin / grain)].value = map(begin, end);
  });
  T result = std::move(identity);
  for (Slot& slot : slots) result = combine(std::move(result), std::move(slot.value));
  return result;
}

// append(begin, end, list) for every block; the blocks' lists joined in block order.
template <class T, class Append>
std::vector<T> parallel_collect(std::int64_t n, std::int64_t grain, Append&& append) {
  std::vector<T> all;
  if (n <= 0) return all;
  grain = std::max<std::int64_t>(grain, 1);
  if (n <= grain) {
    append(std::int64_t{0}, n, all);
    return all;
  }
  std::vector<std::vector<T>> parts(static_cast<std::size_t>((n + grain - 1) / grain));
  parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    append(begin, end, parts[static_cast<std::size_t>(begin / grain)]);
  });
  std::size_t total = 0;
  for (const auto& part : parts) total += part.size();
  all.reserve(total);
  for (auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// f(i) for i = 0 .. n-1, handed out one by one in this order: for tasks of unequal cost, the dearest first.
template <class F>
void parallel_tasks(std::int64_t n, F&& f) {
  const std::int64_t workers = std::min<std::int64_t>(n, thread_cap());
  if (workers <= 1) {
    parallel_for(n, 1, [&](std::int64_t i, std::int64_t) { f(i); });
    return;
  }
  std::atomic<std::int64_t> next{0};
  parallel_for(workers, 1, [&](std::int64_t, std::int64_t) {
    for (std::int64_t i; (i = next.fetch_add(1, std::memory_order_relaxed)) < n;) f(i);
  });
}

// Both functions, at the same time where threads allow. They must not write what the other one uses.
template <class F, class G>
void parallel_invoke(F&& f, G&& g) {
  parallel_for(2, 1, [&](std::int64_t begin, std::int64_t) {
    if (begin == 0)
      f();
    else
      g();
  });
}

}  // namespace overtet
