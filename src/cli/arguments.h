// The words of a command line, before CLI11 sees them: other ways to ask for help, a command that is left
// out, and what is mistyped.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "overtet/result.h"

namespace overtet {

// `help`, `help mesh`, `version` and `-V` as options; `mesh` where only files and options are given. Errors:
// usage, for a command or an option that there is not, with the one that is most like it.
Result<std::vector<std::string>> understood(std::vector<std::string> words, const CLI::App& app);

// Of `candidates` the one that `word` is most likely meant to be; empty where none is like it.
std::string most_like(const std::string& word, const std::vector<std::string>& candidates);

// Numbers from `low` to `high`, said in plain numbers.
CLI::Validator between(double low, double high);
CLI::Validator more_than_zero();

}  // namespace overtet
