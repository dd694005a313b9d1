#include "python/core/calls.h"

#include <pthread.h>
#include <signal.h>

#include <algorithm>
#include <atomic>
#include <cfenv>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "python/core/arrays.h"

namespace overtet::python {

namespace {

constexpr std::chrono::milliseconds kLookPeriod(50);  // how long Ctrl-C and progress wait to be seen

struct Message {
  bool progress = false;
  LogLevel level = LogLevel::info;
  double fraction = 0;
  std::string stage, text;
};

const char* level_name(LogLevel level) {
  constexpr const char* names[] = {"error", "warning", "info", "debug"};
  return names[static_cast<int>(level)];
}

const char* reason_name(ErrorReason reason) {
  constexpr const char* names[] = {"", "exhausted", "endless", "time_limit", "memory_limit"};
  return names[static_cast<int>(reason)];
}

// What the two threads have in common.
struct Shared {
  std::atomic<bool> cancel{false};
  std::mutex mutex;
  std::condition_variable wake;
  bool done = false;
  std::deque<Message> messages;
  std::exception_ptr thrown;
};

RunContext context_of(const py::dict& run, Shared& shared) {
  RunContext c;
  c.cancel = &shared.cancel;
  c.threads = run["threads"].cast<int>();
  c.memory_limit_bytes = run["memory_limit"].cast<std::size_t>();
  c.tetgen_helper = run["tetgen_helper"].cast<std::string>();
  if (!run["time_limit"].is_none())
    c.deadline =
        RunContext::Clock::now() + std::chrono::duration_cast<RunContext::Clock::duration>(
                                       std::chrono::duration<double>(run["time_limit"].cast<double>()));
  if (!run["progress"].is_none())
    c.progress = [&shared](std::string_view stage, double fraction, std::string_view detail) {
      Message m{true, LogLevel::info, fraction, std::string(stage), std::string(detail)};
      const std::lock_guard lock(shared.mutex);
      auto& queue = shared.messages;
      // Of many small steps between two looks the last one is enough.
      if (!queue.empty() && queue.back().progress && queue.back().stage == m.stage)
        queue.back() = std::move(m);
      else
        queue.push_back(std::move(m));
    };
  if (!run["log"].is_none())
    c.log = [&shared](LogLevel level, std::string_view text) {
      const std::lock_guard lock(shared.mutex);
      shared.messages.push_back({false, level, 0, {}, std::string(text)});
    };
  return c;
}

void deliver(const py::dict& run, const std::deque<Message>& messages) {
  for (const Message& m : messages) {
    if (m.progress)
      run["progress"](message_text(m.stage), std::clamp(m.fraction, 0.0, 1.0));
    else
      run["log"](level_name(m.level), message_text(m.text));
  }
}

// Signals are for Python's threads.
template <class F>
std::thread quiet_thread(F&& f) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  try {
    std::thread thread(std::forward<F>(f));
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return thread;
  } catch (...) {
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    throw;
  }
}

}  // namespace

void run_apart(const py::dict& run, const std::function<void(const RunContext&)>& work) {
  Shared shared;
  const RunContext context = context_of(run, shared);
  std::thread thread = quiet_thread([&] {
    // Other modules may have set another rounding, or that tiny numbers are zero; exact arithmetic can have
    // neither.
    std::fesetenv(FE_DFL_ENV);
    try {
      work(context);
    } catch (...) {
      shared.thrown = std::current_exception();
    }
    const std::lock_guard lock(shared.mutex);
    shared.done = true;
    shared.wake.notify_all();
  });
  std::optional<py::error_already_set> raised;
  for (bool done = false; !done;) {
    std::deque<Message> messages;
    {
      const py::gil_scoped_release released;
      std::unique_lock lock(shared.mutex);
      shared.wake.wait_for(lock, kLookPeriod, [&] { return shared.done; });
      messages.swap(shared.messages);
      done = shared.done;
    }
    if (raised) continue;
    try {
      deliver(run, messages);
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    } catch (py::error_already_set& e) {
      raised.emplace(std::move(e));
      shared.cancel = true;
    }
  }
  thread.join();
  if (raised) throw std::move(*raised);
  if (shared.thrown) std::rethrow_exception(shared.thrown);
}

void raise(const Error& error, const Report* report) {
  const py::object of = py::module_::import("overtet._errors").attr("of");
  py::object place = py::none(), certificate = py::none(), json = py::none();
  if (error.place) place = py::make_tuple((*error.place)[0], (*error.place)[1], (*error.place)[2]);
  if (error.certificate) certificate = message_text(to_json(*error.certificate));
  if (report) json = message_text(to_json(*report));
  const py::object exception = of(
      static_cast<int>(error.code), message_text(error.message), place, reason_name(error.reason), error.face,
      certificate, error.certificate ? message_text(explain(*error.certificate)) : py::str(""), json);
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(exception.ptr())), exception.ptr());
  throw py::error_already_set();
}

}  // namespace overtet::python
