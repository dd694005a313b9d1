// To be preloaded: an allocation that fails.
//
//   OVERTET_FAIL_AT=N      the N-th allocation after main() has begun fails (from 1; 0: none does)
//   OVERTET_FAIL_FOR=M     and M - 1 that follow (1 without it)
//   OVERTET_FAIL_IN=NAME   in the program of that name only
//   OVERTET_FAIL_COUNT=F   at its end the program writes to the file F how many there were
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdio>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
extern char* program_invocation_short_name;
}

namespace {

std::atomic<long> count{0};
long fail_at = 0, fail_for = 1;
bool counts = false;
char count_file[1024];

bool fails() {
  if (!counts) return false;
  const long n = count.fetch_add(1, std::memory_order_relaxed) + 1;
  if (fail_at == 0 || n < fail_at || n - fail_at >= fail_for) return false;
  errno = ENOMEM;
  return true;
}

void write_count() {
  counts = false;
  if (count_file[0] == 0) return;
  char text[32];
  const int n = std::snprintf(text, sizeof text, "%ld\n", count.load());
  const int file = open(count_file, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  (void)!write(file, text, static_cast<std::size_t>(n));
  close(file);
}

int (*real_main)(int, char**, char**) = nullptr;

int counted_main(int argc, char** argv, char** environment) {
  const char* const at = getenv("OVERTET_FAIL_AT");
  const char* const many = getenv("OVERTET_FAIL_FOR");
  const char* const in = getenv("OVERTET_FAIL_IN");
  const char* const file = getenv("OVERTET_FAIL_COUNT");
  if (at && (!in || strcmp(in, program_invocation_short_name) == 0)) {
    fail_at = atol(at);
    if (many) fail_for = atol(many);
    if (file) strncpy(count_file, file, sizeof count_file - 1);
    atexit(write_count);
    counts = true;
  }
  return real_main(argc, argv, environment);
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(), void (*fini)(),
                      void (*rtld_fini)(), void* stack_end) {
  using Start = int(int (*)(int, char**, char**), int, char**, void (*)(), void (*)(), void (*)(), void*);
  real_main = main;
  auto* const next = reinterpret_cast<Start*>(dlsym(RTLD_NEXT, "__libc_start_main"));
  return next(counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}

void* malloc(std::size_t n) { return fails() ? nullptr : __libc_malloc(n); }
void* calloc(std::size_t n, std::size_t size) { return fails() ? nullptr : __libc_calloc(n, size); }
void* realloc(void* p, std::size_t n) { return fails() ? nullptr : __libc_realloc(p, n); }
void* memalign(std::size_t alignment, std::size_t n) {
  return fails() ? nullptr : __libc_memalign(alignment, n);
}
void* aligned_alloc(std::size_t alignment, std::size_t n) {
  return fails() ? nullptr : __libc_memalign(alignment, n);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t n) {
  void* const got = fails() ? nullptr : __libc_memalign(alignment, n);
  if (!got) return ENOMEM;
  *p = got;
  return 0;
}
}
