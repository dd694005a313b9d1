// What every public function does around its work.
#pragma once

#include <exception>
#include <utility>

#include "kernels/parallel/parallel.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/run/run_monitor.h"

namespace overtet {

// f(context) on the context's number of threads, with its memory watched. f returns a Result; what it throws
// comes back as an error.
template <class F>
auto guarded(const RunContext& outer, F&& f) -> decltype(f(outer)) {
  try {
    RunMonitor watch(outer);
    const ScopedThreads threads(outer.threads);
    try {
      auto result = std::forward<F>(f)(watch.context());
      if (!result) return watch.explained(result.error());
      return result;
    } catch (const std::exception&) {
      return watch.explained(error_of_exception());
    }
  } catch (const std::exception&) {
    return error_of_exception();
  }
}

}  // namespace overtet
