// Where the programs are that do a part of the work in processes of their own. Internal to the library.
#pragma once

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

}  // namespace overtet
