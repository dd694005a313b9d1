#include "overtet/run_context.h"

#include <unistd.h>

#include <cstdio>
#include <string>

namespace overtet {

namespace {

std::size_t resident_bytes() {
  std::FILE* statm = std::fopen("/proc/self/statm", "r");
  if (!statm) return 0;
  unsigned long total = 0, resident = 0;
  const int got = std::fscanf(statm, "%lu %lu", &total, &resident);
  std::fclose(statm);
  return got == 2 ? resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE)) : 0;
}

std::string mebibytes(std::size_t bytes) { return std::to_string(bytes >> 20) + " MiB"; }

}  // namespace

std::optional<Error> RunContext::stop() const {
  if (cancel && cancel->load(std::memory_order_relaxed))
    return Error{ErrorCode::interrupted, "Interrupted; nothing was written."};
  if (deadline != Clock::time_point::max() && Clock::now() >= deadline)
    return Error{ErrorCode::limit, "The time limit was reached; allow more with --time-limit."};
  return std::nullopt;
}

std::optional<Error> RunContext::no_room_for(std::size_t bytes) const {
  if (memory_limit_bytes == 0) return std::nullopt;
  const std::size_t now = resident_bytes();
  if (now + bytes <= memory_limit_bytes) return std::nullopt;
  return Error{ErrorCode::limit, "The memory limit of " + mebibytes(memory_limit_bytes) +
                                     " would be passed (" + mebibytes(now) + " in use, " +
                                     mebibytes(bytes) + " more needed); allow more with --memory-limit."};
}

double RunContext::seconds_left() const {
  if (deadline == Clock::time_point::max()) return 1e9;
  const double left = std::chrono::duration<double>(deadline - Clock::now()).count();
  return left > 0 ? left : 0;
}

}  // namespace overtet
