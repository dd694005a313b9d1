#include <cstdio>

#include "overtet/io.h"
#include "overtet/repair.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"

namespace overtet {

int run(const RepairCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<SurfaceFormat> format = surface_format_of(command.output);
  if (!format && !command.surface_only && tet_format_of(command.output)) {
    MeshCommand mesh;
    mesh.input = command.input, mesh.output = command.output, mesh.report = command.report;
    mesh.on_infeasible = "repair";
    mesh.max_move = command.max_move;
    mesh.clean = command.clean;
    return run(mesh, common, terminal);
  }
  if (!format) return fail(terminal, format.error());
  if (!command.report.empty())
    return fail(terminal,
                {ErrorCode::usage, "A report is written only if a tet mesh is made; leave out --report."});
  if (command.input == command.output)
    return fail(terminal, {ErrorCode::usage, "The output would overwrite the input; choose another name."});
  OutputProbe output;
  if (Status s = output.open(command.output); !s) return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context.deadline, context.memory_limit_bytes,
                    [&](const Error& error) { terminal.error(with_hint(error)); });
  const Result<InputSurface> loaded = load(command.input, command.clean, context, terminal);
  if (!loaded) return fail(terminal, loaded.error());
  const InputSurface& input = loaded.value();
  if (input.cleanup.problem) return fail(terminal, *input.cleanup.problem);
  SurfaceRepairOptions options;
  options.max_relative_move = command.max_move / 100;
  const Result<SurfaceRepair> repaired = repair_surface(input.surface(), options, context);
  watchdog.dismiss();
  if (!repaired) return fail(terminal, input.in_file(repaired.error()));
  if (interrupt_flag()) return fail(terminal, {ErrorCode::interrupted, "Interrupted; nothing was written."});
  const SurfaceRepair& r = repaired.value();
  if (Status s = write_surface(command.output, r.surface, format.value(), context); !s)
    return fail(terminal, s.error());
  terminal.clear();
  char most[96];
  std::snprintf(most, sizeof most, "%.4f %% of the diagonal at most (%.4f on average).",
                100 * r.max_relative_move, 100 * r.mean_relative_move);
  terminal.say(command.output + ": " + std::to_string(r.moved.size()) + " of " +
               std::to_string(r.surface.V.rows()) + " vertices moved, by " + most +
               " The surface has a tet mesh.");
  return 0;
}

}  // namespace overtet
