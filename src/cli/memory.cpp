#include "src/cli/memory.h"

#include <execinfo.h>
#include <gmp.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <exception>
#include <new>
#include <string_view>

#include "overtet/io.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

std::atomic<bool> has_failed{false};  // an allocation

[[noreturn]] void fail_allocation() {
  has_failed = true;
  throw std::bad_alloc();
}

// Nothing may be thrown through GMP: mpz_mul() has freed its result's limbs when it asks for more, and the
// number's destructor would free them again.
void* gmp_allocate(std::size_t bytes) {
  void* const p = std::malloc(bytes);
  if (!p) end_for_memory();
  return p;
}

void* gmp_reallocate(void* old, std::size_t, std::size_t bytes) {
  void* const p = std::realloc(old, bytes);
  if (!p) end_for_memory();
  return p;
}

void gmp_free(void* p, std::size_t) { std::free(p); }

std::atomic<bool> may_exit{false};

void end_of_program() {
  if (!may_exit)
    end_for_memory("overtet: A library gave up, most likely because there is not enough memory.\n");
}

// Allocates nothing. An exception in the air that means anything else is a bug, and stays one.
[[noreturn]] void last_words() {
  bool for_memory = has_failed;
  try {
    if (const std::exception_ptr e = std::current_exception()) std::rethrow_exception(e);
  } catch (const std::bad_alloc&) {
    for_memory = true;
  } catch (...) {
  }
  if (for_memory) end_for_memory();
  constexpr std::string_view words = "overtet: Internal error, please report it.\n";
  (void)!::write(STDERR_FILENO, words.data(), words.size());
  std::abort();
}

// The destructors of a thread's own objects, last first. In this order, and by this name, they are kept for
// the compiler; glibc's own function aborts where it has no memory for that. Those of the first thread are
// never called: it ends with the program.
struct ThreadEnd {
  void (*destroy)(void*);
  void* object;
  ThreadEnd* before;
};
thread_local ThreadEnd* thread_ends = nullptr;

void end_thread(void*) {
  while (ThreadEnd* const end = thread_ends) {
    thread_ends = end->before;
    end->destroy(end->object);
    std::free(end);
  }
}

pthread_key_t thread_key() {
  static const pthread_key_t key = [] {
    pthread_key_t made = 0;
    if (pthread_key_create(&made, end_thread) != 0) std::abort();
    return made;
  }();
  return key;
}

}  // namespace

void end_for_memory(std::string_view words) {
  begin_to_end(exit_code(ErrorCode::limit));
  if (has_met_memory_limit())
    words = "overtet: The memory limit was reached; allow more with --memory-limit.\n";
  if (words.empty()) words = "overtet: There is not enough memory.\n";
  (void)!::write(STDERR_FILENO, words.data(), words.size());
  end_at_once(exit_code(ErrorCode::limit));
}

void leaving() { may_exit = true; }

void install_memory_handlers() {
  (void)thread_key();
  (void)std::atexit(end_of_program);
  // glibc loads what it needs for exceptions in its own functions when it first meets one, and aborts without
  // memory.
  void* frame = nullptr;
  (void)::backtrace(&frame, 1);
  mp_set_memory_functions(gmp_allocate, gmp_reallocate, gmp_free);
  std::set_new_handler(fail_allocation);
  std::set_terminate(last_words);
}

}  // namespace overtet

extern "C" int __cxa_thread_atexit(void (*destroy)(void*), void* object, void*) noexcept {
  using namespace overtet;
  auto* const end = static_cast<ThreadEnd*>(std::malloc(sizeof(ThreadEnd)));
  if (!end) end_for_memory();
  *end = {destroy, object, thread_ends};
  thread_ends = end;
  (void)pthread_setspecific(thread_key(), end);
  return 0;
}
