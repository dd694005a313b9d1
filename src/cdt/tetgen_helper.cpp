#include "src/cdt/tetgen_helper.h"

#include <dlfcn.h>
#include <unistd.h>

namespace overtet {

namespace {

bool runs(const std::string& path) { return access(path.c_str(), X_OK) == 0; }

std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/')); }

std::string running_program() {
  std::string path(4096, '\0');
  const ssize_t n = readlink("/proc/self/exe", path.data(), path.size());
  path.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  return path;
}

// The shared library that this function is in; of a static one, the program.
std::string this_library() {
  Dl_info info;
  return dladdr(reinterpret_cast<void*>(&this_library), &info) && info.dli_fname ? info.dli_fname : "";
}

}  // namespace

Result<std::string> tetgen_helper(const RunContext& context) {
  if (!context.tetgen_helper.empty()) {
    if (runs(context.tetgen_helper)) return context.tetgen_helper;
    return Error{ErrorCode::io, "Cannot run the program overtet-tetgen as " + context.tetgen_helper +
                                    "; TetGen runs in it."};
  }
  const std::string beside_program = folder_of(running_program()), beside_library = folder_of(this_library());
  for (const std::string& path :
       {beside_program + "/overtet-tetgen", beside_program + "/" OVERTET_FROM_BIN "/overtet/overtet-tetgen",
        beside_library + "/" OVERTET_FROM_LIB "/overtet/overtet-tetgen",
        std::string(OVERTET_LIBEXEC "/overtet/overtet-tetgen"),
        std::string("/usr/libexec/overtet/overtet-tetgen")})
    if (runs(path)) return path;
  return Error{ErrorCode::io,
               "The program overtet-tetgen, in which TetGen runs, is missing: put it into the folder " +
                   beside_program + ", beside the program, or install Overtet again."};
}

}  // namespace overtet
