#include "src/run/usable.h"

#include <sched.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <thread>

#include "overtet/run_context.h"

namespace overtet {

namespace {

std::optional<double> number_of(const std::string& word) {
  double x = 0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), x);
  if (code != std::errc() || end != word.data() + word.size() || !(x > 0)) return std::nullopt;
  return x;
}

std::string first_words(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

// cpu.max: "QUOTA PERIOD", QUOTA may be "max".
std::optional<double> quota_of_second(const std::string& folder) {
  std::istringstream in(first_words(folder + "/cpu.max"));
  std::string quota, period;
  in >> quota >> period;
  const auto q = number_of(quota), p = number_of(period);
  return q && p ? std::optional(*q / *p) : std::nullopt;
}

// The first version has a file for each; -1: no quota.
std::optional<double> quota_of_first(const std::string& folder) {
  const auto q = number_of(first_words(folder + "/cpu.cfs_quota_us"));
  const auto p = number_of(first_words(folder + "/cpu.cfs_period_us"));
  return q && p ? std::optional(*q / *p) : std::nullopt;
}

bool names_cpu(const std::string& controllers) {
  std::istringstream in(controllers);
  for (std::string word; std::getline(in, word, ',');)
    if (word == "cpu") return true;
  return false;
}

}  // namespace

std::optional<double> cores_of_quota(const std::string& groups, const std::string& root) {
  std::optional<double> least;
  const auto allow = [&](const std::optional<double>& cores) {
    if (cores && (!least || *cores < *least)) least = cores;
  };
  std::istringstream in(groups);
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (!controllers.empty() && !names_cpu(controllers)) continue;
    // In a container the path may be that of the host: what is there of it counts.
    for (std::string path = line.substr(second + 1);; path.erase(path.rfind('/'))) {
      if (path == "/") path.clear();
      if (controllers.empty()) {
        allow(quota_of_second(root + path));
        allow(quota_of_second(root + "/unified" + path));
      } else {
        allow(quota_of_first(root + "/cpu" + path));
        allow(quota_of_first(root + "/" + controllers + path));
      }
      if (path.empty() || path.find('/') == std::string::npos) break;
    }
  }
  return least;
}

std::optional<std::int64_t> environment_number(const char* name) {
  const char* text = std::getenv(name);
  if (!text) return std::nullopt;
  std::int64_t x = 0;
  const auto [end, code] = std::from_chars(text, text + std::strlen(text), x);
  return code == std::errc() && *end == 0 && x > 0 ? std::optional(x) : std::nullopt;
}

std::optional<std::int64_t> slurm_memory_bytes() {
  constexpr std::int64_t mebibyte = 1 << 20, most = std::numeric_limits<std::int64_t>::max() >> 21;
  const auto bytes = [&](std::int64_t mib) { return std::min(mib, most) * mebibyte; };
  if (const auto node = environment_number("SLURM_MEM_PER_NODE")) return bytes(*node);
  const auto one = environment_number("SLURM_MEM_PER_CPU");
  if (!one) return std::nullopt;
  const std::int64_t cores = environment_number("SLURM_CPUS_PER_TASK").value_or(1);
  return bytes(std::min(*one, most) <= most / cores ? *one * cores : most);
}

int usable_cores() {
  int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  cpu_set_t allowed;
  if (::sched_getaffinity(0, sizeof allowed, &allowed) == 0) cores = std::max(1, CPU_COUNT(&allowed));
  std::ifstream in("/proc/self/cgroup");
  const std::string groups{std::istreambuf_iterator<char>(in), {}};
  if (const auto quota = cores_of_quota(groups, "/sys/fs/cgroup"); quota && *quota < cores)
    cores = std::max(1, static_cast<int>(*quota));
  if (const auto task = environment_number("SLURM_CPUS_PER_TASK"); task && *task < cores)
    cores = static_cast<int>(*task);
  return cores;
}

}  // namespace overtet
