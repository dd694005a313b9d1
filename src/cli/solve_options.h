// The options of `overtet solve`: each belongs to some kinds of problems and is refused for the others.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "src/cli/solve_kinds.h"

namespace overtet {

CLI::App* add_solve(CLI::App& app, SolveCommand& solve);

// pre: kind is one that add_solve() lets through.
using SolveFunction = Result<SolveSummary>(const SolveCommand&, const RunContext&, const RunContext&);
SolveFunction* solver_of(const std::string& kind);

}  // namespace overtet
