// To be preloaded: a clock that is set while the program runs, and a file that others write to while it is
// read.
//
//   OVERTET_CLOCK=1        the time of day jumps back and forth by days at every look
//   OVERTET_CHANGE=FILE    after the first read from FILE it is changed:
//   OVERTET_HOW=HOW        grow, truncate, rewrite (as long as before) or replace (another file of that name)
#include <dlfcn.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>

namespace {

template <class Function>
Function* next_of(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

time_t jump() {
  static std::atomic<unsigned> looks{0};
  return getenv("OVERTET_CLOCK") ? (looks++ % 2 == 0 ? 864'000 : -864'000) : 0;
}

void change(const char* file) {
  const char* const how = getenv("OVERTET_HOW");
  if (!how) return;
  if (strcmp(how, "replace") == 0) {
    unlink(file);
    close(open(file, O_WRONLY | O_CREAT, 0600));
    return;
  }
  struct stat info {};
  stat(file, &info);
  if (strcmp(how, "truncate") == 0) (void)!truncate(file, info.st_size / 2);
  const int out = open(file, O_WRONLY);
  if (strcmp(how, "grow") == 0) {
    lseek(out, 0, SEEK_END);
    (void)!write(out, "# more\n", 7);
  }
  // In the middle, and with the times of a file that is written to a little later.
  if (strcmp(how, "rewrite") == 0) {
    (void)!pwrite(out, "7", 1, info.st_size - 2);
    timespec times[2] = {info.st_atim, info.st_mtim};
    times[1].tv_sec += 1;
    futimens(out, times);
  }
  close(out);
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* now) {
  static auto* const next = next_of<int(clockid_t, timespec*)>("clock_gettime");
  const int result = next(clock, now);
  if (clock == CLOCK_REALTIME) now->tv_sec += jump();
  return result;
}

int gettimeofday(timeval* now, void* zone) {
  static auto* const next = next_of<int(timeval*, void*)>("gettimeofday");
  const int result = next(now, zone);
  now->tv_sec += jump();
  return result;
}

time_t time(time_t* now) {
  static auto* const next = next_of<time_t(time_t*)>("time");
  const time_t t = next(nullptr) + jump();
  if (now) *now = t;
  return t;
}

ssize_t read(int file, void* data, size_t bytes) {
  static auto* const next = next_of<ssize_t(int, void*, size_t)>("read");
  static std::atomic<bool> done{false};
  // The larger half first, so that there is something left to read.
  const char* const changed = getenv("OVERTET_CHANGE");
  char path[4096] = {}, link[64];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  if (!changed || done || readlink(link, path, sizeof path - 1) <= 0 || strcmp(path, changed) != 0)
    return next(file, data, bytes);
  done = true;
  const ssize_t got = next(file, data, bytes < 1000 ? bytes : 1000);
  change(changed);
  return got;
}
}
