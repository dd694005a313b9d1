#include "src/run/helper_program.h"

#include <dlfcn.h>
#include <signal.h>
#include <unistd.h>

namespace overtet {

namespace {

std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/')); }

// The shared library that this function is in; of a static one, the program.
std::string this_library() {
  Dl_info info;
  return dladdr(reinterpret_cast<void*>(&this_library), &info) && info.dli_fname ? info.dli_fname : "";
}

}  // namespace

bool can_run(const std::string& path) { return access(path.c_str(), X_OK) == 0; }

std::string program_folder() {
  std::string path(4096, '\0');
  const ssize_t n = readlink("/proc/self/exe", path.data(), path.size());
  path.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  return folder_of(path);
}

std::optional<std::string> helper_program(const std::string& name) {
  const std::string beside_program = program_folder(), beside_library = folder_of(this_library());
  for (const std::string& path :
       {beside_program + "/" + name, beside_program + "/" OVERTET_FROM_BIN "/overtet/" + name,
        beside_library + "/" OVERTET_FROM_LIB "/overtet/" + name, OVERTET_LIBEXEC "/overtet/" + name,
        "/usr/libexec/overtet/" + name})
    if (can_run(path)) return path;
  return std::nullopt;
}

int start_helper(const std::string& path, char* const argv[], const posix_spawn_file_actions_t& actions,
                 pid_t& id) {
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  const int failed = posix_spawn(&id, path.c_str(), &actions, &attributes, argv, environ);
  posix_spawnattr_destroy(&attributes);
  return failed;
}

}  // namespace overtet
