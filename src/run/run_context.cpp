#include "overtet/run_context.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>

#include "kernels/core/tuning.h"
#include "src/run/tuning.h"
#include "src/run/usable.h"

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

// The number that a file begins with, or that follows `key` in it; `none` where there is no such number.
std::size_t number_in(const std::string& file, const std::string& key, std::size_t none) {
  std::ifstream in(file);
  std::string word;
  while (!key.empty() && word != key)
    if (!(in >> word)) return none;
  std::size_t number = 0;
  return in >> number ? number : none;
}

std::string mebibytes(std::size_t bytes) { return std::to_string(bytes >> 20) + " MiB"; }

}  // namespace

std::optional<Error> RunContext::stop() const {
  if (cancel && cancel->load(std::memory_order_relaxed))
    return Error{ErrorCode::interrupted, "Interrupted; nothing was written."};
  if (deadline != Clock::time_point::max() && Clock::now() >= deadline)
    return Error{.code = ErrorCode::limit,
                 .message = "The time limit was reached.",
                 .reason = ErrorReason::time_limit};
  return std::nullopt;
}

std::optional<Error> RunContext::no_name() const {
  if (!may_name || may_name()) return std::nullopt;
  if (auto why = stop()) return why;
  return Error{ErrorCode::interrupted, "Interrupted; nothing was written."};
}

std::optional<Error> RunContext::no_room_for(std::size_t bytes) const {
  if (memory_limit_bytes == 0) return std::nullopt;
  const std::size_t now = resident_bytes();
  if (now + bytes <= memory_limit_bytes) return std::nullopt;
  return Error{.code = ErrorCode::limit,
               .message = "The memory limit of " + mebibytes(memory_limit_bytes) + " would be exceeded (" +
                          mebibytes(now) + " in use, " + mebibytes(bytes) + " more needed).",
               .reason = ErrorReason::memory_limit};
}

std::size_t usable_memory_bytes() {
  constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::size_t usable = none;
  if (const std::size_t free = number_in("/proc/meminfo", "MemAvailable:", none); free != none)
    usable = resident_bytes() + free * 1024;
  // A line a hierarchy: number:controllers:path. The second version has one for all, without a name.
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1),
                      path = line.substr(second + 1);
    if (controllers.empty())
      for (const std::string& at : {path, std::string()})
        usable = std::min(usable, number_in("/sys/fs/cgroup" + at + "/memory.max", "", none));
    else if (controllers == "memory")
      for (const std::string& at : {path, std::string()})
        usable =
            std::min(usable, number_in("/sys/fs/cgroup/memory" + at + "/memory.limit_in_bytes", "", none));
  }
  if (const auto slurm = slurm_memory_bytes()) usable = std::min(usable, static_cast<std::size_t>(*slurm));
  return usable == none ? 0 : usable;
}

std::chrono::microseconds look_again_after(std::size_t bytes) {
  using std::chrono::microseconds;
  constexpr auto longest = std::chrono::duration_cast<microseconds>(kLookPeriod);
  const microseconds filled(static_cast<std::int64_t>(1e6 * static_cast<double>(bytes) / kFillRate));
  return std::clamp(filled, kShortestLook, longest);
}

double RunContext::seconds_left() const {
  if (deadline == Clock::time_point::max()) return 1e9;
  const double left = std::chrono::duration<double>(deadline - Clock::now()).count();
  return left > 0 ? left : 0;
}

}  // namespace overtet
