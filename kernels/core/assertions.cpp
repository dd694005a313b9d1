#include "kernels/core/assertions.h"

#include <cstdio>
#include <cstdlib>

namespace overtet::assertion {

void fail(const char* kind, const char* text, const char* file, int line, std::string_view message) {
  std::fprintf(stderr, "%s:%d: %s failed: %s%s%.*s\n", file, line, kind, text, message.empty() ? "" : ": ",
               static_cast<int>(message.size()), message.data());
  std::abort();
}

}  // namespace overtet::assertion
