// What the program does where there is no memory left: it says so and ends with exit code 6, wherever that
// is.
#pragma once

#include <string_view>

#include "overtet/result.h"

namespace overtet {

// GMP would abort where an allocation fails, and can take no exception: from here on it ends the program with
// a sentence. So does an exception that nobody may catch any more (one that leaves a destructor, or a
// thread), and a library that calls exit() (libgomp, OpenBLAS) before leaving() was called.
void install_memory_handlers();
void leaving();
// Says so, in these words if there are any and no memory limit was met, and ends the program; takes no
// memory.
[[noreturn]] void end_for_memory(std::string_view words = {});

// f(), which returns a Result; what it throws comes back as an error.
template <class F>
auto caught(F&& f) -> decltype(f()) {
  try {
    return f();
  } catch (...) {
    return error_of_exception();
  }
}

}  // namespace overtet
