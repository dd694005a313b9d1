#include <chrono>
#include <cstdio>

#include "src/cli/memory.h"
#include "src/cli/signals.h"
#include "src/cli/solve_kinds.h"
#include "src/cli/solve_options.h"

namespace overtet {

int run(const SolveCommand& command, const CommonOptions& common, Terminal& terminal) {
  if (same_file(command.input, command.output))
    return fail(terminal, {ErrorCode::usage, "The output would overwrite the input; choose another name."});
  OutputProbe probe;
  if (Status s = probe.open(command.output); !s) return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context, common.start,
                    [&](const Error& error) { terminal.last_words(with_hint(error)); });
  Result<SolveSummary> solved =
      caught([&] { return solver_of(command.kind)(command, context, watchdog.writing(context)); });
  if (!solved) return fail(watchdog, terminal, solved.error());
  terminal.clear();
  const double seconds = std::chrono::duration<double>(RunContext::Clock::now() - common.start).count();
  if (command.json) {
    nlohmann::ordered_json j = {{"kind", command.kind}};
    j.update(solved.value().figures);
    j["seconds"] = seconds;
    const std::string printed = j.dump(2) + "\n";
    if (std::fputs(printed.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
      return fail(terminal, {ErrorCode::io, "Cannot write standard output."});
    return 0;
  }
  char text[40];
  std::snprintf(text, sizeof text, ", %.1f s.", seconds);
  terminal.say(command.output + ": " + solved.value().sentence + text);
  return 0;
}

}  // namespace overtet
