// Where the programs are that do a part of the work in processes of their own. Internal to the library.
#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <optional>
#include <string>

namespace overtet {

bool can_run(const std::string& path);

// The folder of the running program.
std::string program_folder();

// The path of an executable file of that name: the first one beside the running program (as in a build tree),
// in the libexec folder of the program's or of the shared library's installation, where it was to be
// installed, and where packages put it. None: there is none.
std::optional<std::string> helper_program(const std::string& name);

// Starts such a program in a process group of its own, as Ctrl-C reaches the parent and the parent decides,
// with all signals as they are by default. 0, or the number of what went wrong (errno.h); then no process is
// there.
int start_helper(const std::string& path, char* const argv[], const posix_spawn_file_actions_t& actions,
                 pid_t& id);

}  // namespace overtet
