// Man pages, and completions for shells, from the commands and options themselves, so that they cannot
// differ.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "overtet/result.h"

namespace overtet {

// A man page in roff: of a command, or of the program where the name is empty. Errors: usage (no such
// command).
Result<std::string> manual_of(const CLI::App& app, const std::string& command);

// A script that teaches a shell ("bash", "zsh" or "fish") the commands, the options, and the words that some
// options take; file names everywhere else.
std::string completion_for(const std::string& shell, const CLI::App& app);

}  // namespace overtet
