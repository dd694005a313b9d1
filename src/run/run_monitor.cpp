#include "src/run/run_monitor.h"

#include <dirent.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "kernels/core/tuning.h"

namespace overtet {

namespace {

struct Pages {
  unsigned long mapped = 0, resident = 0;
};

Pages pages_of(long process) {
  Pages pages;
  const std::string path = "/proc/" + std::to_string(process) + "/statm";
  std::FILE* file = std::fopen(path.c_str(), "r");
  if (!file) return pages;
  if (std::fscanf(file, "%lu %lu", &pages.mapped, &pages.resident) != 2) pages = {};
  std::fclose(file);
  return pages;
}

std::string program_of(long process) {
  char path[512];
  const ssize_t n = readlink(("/proc/" + std::to_string(process) + "/exe").c_str(), path, sizeof path);
  return n > 0 ? std::string(path, static_cast<std::size_t>(n)) : std::string();
}

// Until a new process runs its own program it has the pages of its parent, and they must not count twice.
bool shares_pages(long child, const Pages& its, long parent) {
  const Pages of_parent = pages_of(parent);
  const unsigned long more = std::max(its.mapped, of_parent.mapped),
                      less = std::min(its.mapped, of_parent.mapped);
  return more - less <= more / 64 && program_of(child) == program_of(parent);
}

// The children of each thread of a process.
void children_of(long process, std::vector<long>& out) {
  const std::string tasks = "/proc/" + std::to_string(process) + "/task";
  DIR* directory = opendir(tasks.c_str());
  if (!directory) return;
  while (const dirent* entry = readdir(directory)) {
    if (entry->d_name[0] == '.') continue;
    const std::string path = tasks + "/" + entry->d_name + "/children";
    if (std::FILE* file = std::fopen(path.c_str(), "r")) {
      long child = 0;
      while (std::fscanf(file, "%ld", &child) == 1) out.push_back(child);
      std::fclose(file);
    }
  }
  closedir(directory);
}

}  // namespace

std::size_t tree_resident_bytes() {
  std::vector<long> processes = {static_cast<long>(getpid())}, parents = {-1};
  std::size_t pages = 0;
  for (std::size_t i = 0; i < processes.size() && i < 64; ++i) {
    const Pages its = pages_of(processes[i]);
    if (parents[i] < 0 || !shares_pages(processes[i], its, parents[i])) pages += its.resident;
    children_of(processes[i], processes);
    parents.resize(processes.size(), processes[i]);
  }
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

RunMonitor::RunMonitor(const RunContext& outer)
    : inner_(outer), outer_cancel_(outer.cancel), limit_(outer.memory_limit_bytes) {
  inner_.cancel = &stop_;
  inner_.stage_peak_bytes = &stage_peak_;
  // Of runs that end before the first look the system knows the peak (peak_bytes()), and a look at all
  // processes is not free. But what is too much or unwanted already must not begin.
  if ((limit_ > 0 && peak_bytes() > limit_) || (outer_cancel_ && outer_cancel_->load())) look();
  // Signals are for the thread that the caller has chosen, never for this one.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([this] { watch(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

RunMonitor::~RunMonitor() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

std::size_t RunMonitor::look() {
  const std::size_t now = tree_resident_bytes();
  if (now > peak_) peak_ = now;
  // A stage that begins meanwhile sets it to 0; what is in use now counts for either.
  if (now > stage_peak_) stage_peak_ = now;
  if (limit_ > 0 && now > limit_) {
    memory_exceeded_ = true;
    stop_ = true;
  }
  if (outer_cancel_ && outer_cancel_->load(std::memory_order_relaxed)) stop_ = true;
  return now;
}

void RunMonitor::watch() {
  std::unique_lock lock(mutex_);
  std::size_t used = 0;
  const auto rest = [&] { return used < limit_ ? limit_ - used : 0; };
  const auto pause = [&] {
    return limit_ == 0 || stop_ ? std::chrono::microseconds(kLookPeriod) : look_again_after(rest());
  };
  while (!wake_.wait_for(lock, pause(), [this] { return ended_; })) used = look();
}

std::size_t RunMonitor::peak_bytes() const {
  std::size_t peak = peak_;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    if (getrusage(who, &usage) == 0) peak = std::max(peak, static_cast<std::size_t>(usage.ru_maxrss) * 1024);
  }
  return peak;
}

Error RunMonitor::explained(Error error) const {
  const bool short_of_memory = error.code == ErrorCode::limit && error.reason == ErrorReason::none;
  if ((error.code == ErrorCode::interrupted || short_of_memory) && memory_exceeded_ &&
      !(outer_cancel_ && outer_cancel_->load(std::memory_order_relaxed)))
    return {.code = ErrorCode::limit,
            .message = "The memory limit of " + std::to_string(limit_ >> 20) + " MiB was reached.",
            .reason = ErrorReason::memory_limit};
  return error;
}

}  // namespace overtet
