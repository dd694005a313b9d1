// How Python calls the library: in a thread of its own, so that Ctrl-C is seen; errors become exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <functional>

#include "overtet/report.h"
#include "overtet/result.h"
#include "overtet/run_context.h"

namespace overtet::python {

namespace py = pybind11;

// Runs `work` in a thread of its own and waits for it without the GIL. `run` has threads, time_limit (seconds
// or None), memory_limit (bytes, 0: none), tetgen_helper, progress and log (callables or None). These two are
// called here, in the thread that called: what they raise ends the run, as a signal does whose Python handler
// raises, and comes out of this function. What `work` throws does, too. Nothing of the run is left when this
// returns.
void run_apart(const py::dict& run, const std::function<void(const RunContext&)>& work);

// The error as an exception of overtet/_errors.py. report: what the run did, if anything is known.
[[noreturn]] void raise(const Error& error, const Report* report = nullptr);

// The value; an error is raised.
template <class T>
T value_of(Result<T> result, const Report* report = nullptr) {
  if (!result) raise(result.error(), report);
  return std::move(result).value();
}

// A function of the library that gives a Result: f(context).
template <class F>
auto call(const py::dict& run, F&& f) {
  using R = decltype(f(RunContext()));
  R result = Error{};
  run_apart(run, [&](const RunContext& context) { result = f(context); });
  return result;
}

}  // namespace overtet::python
