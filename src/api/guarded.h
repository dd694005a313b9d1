// What every public function does around its work.
#pragma once

#include <exception>
#include <new>
#include <string>
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
    auto result = std::forward<F>(f)(watch.context());
    if (!result) return watch.explained(result.error());
    return result;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::limit, "There is not enough memory for this model."};
  } catch (const std::exception& e) {
    return Error{ErrorCode::internal, std::string("Internal error, please report it: ") + e.what() + "."};
  }
}

}  // namespace overtet
