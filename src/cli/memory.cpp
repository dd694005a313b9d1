#include "src/cli/memory.h"

#include <gmp.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <system_error>

#include "overtet/io.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

std::atomic<bool> has_failed{false};  // an allocation

[[noreturn]] void fail_allocation() {
  has_failed = true;
  throw std::bad_alloc();
}

void* gmp_allocate(std::size_t bytes) {
  void* const p = std::malloc(bytes);
  if (!p) fail_allocation();
  return p;
}

void* gmp_reallocate(void* old, std::size_t, std::size_t bytes) {
  void* const p = std::realloc(old, bytes);
  if (!p) fail_allocation();
  return p;
}

void gmp_free(void* p, std::size_t) { std::free(p); }

// Allocates nothing. An exception in the air that means anything else is a bug, and stays one.
[[noreturn]] void last_words() {
  bool for_memory = has_failed;
  std::string_view words = "overtet: Internal error, please report it.\n";
  try {
    if (const std::exception_ptr e = std::current_exception()) std::rethrow_exception(e);
  } catch (const std::bad_alloc&) {
    for_memory = true;
  } catch (...) {
  }
  if (!for_memory) {
    (void)!::write(STDERR_FILENO, words.data(), words.size());
    std::abort();
  }
  words = "overtet: There is not enough memory.\n";
  (void)!::write(STDERR_FILENO, words.data(), words.size());
  end_at_once(exit_code(ErrorCode::limit));
}

}  // namespace

void install_memory_handlers() {
  mp_set_memory_functions(gmp_allocate, gmp_reallocate, gmp_free);
  std::set_new_handler(fail_allocation);
  std::set_terminate(last_words);
}

Error caught_error() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return {ErrorCode::limit, "There is not enough memory for this model."};
  } catch (const std::system_error& e) {
    // Of threads that cannot be started.
    if (e.code() == std::errc::resource_unavailable_try_again || e.code() == std::errc::not_enough_memory)
      return {ErrorCode::limit, "There is not enough memory, or there are too many threads."};
    return {ErrorCode::internal, std::string("Internal error, please report it: ") + e.what() + "."};
  } catch (const std::exception& e) {
    return {ErrorCode::internal, std::string("Internal error, please report it: ") + e.what() + "."};
  } catch (...) {
    return {ErrorCode::internal, "Internal error, please report it."};
  }
}

}  // namespace overtet
