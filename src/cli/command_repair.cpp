#include <cstdio>

#include "kernels/parallel/parallel.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"
#include "src/io/file.h"
#include "src/io/surface_io.h"
#include "src/io/tet_io.h"
#include "src/pipeline/pipeline.h"

namespace overtet {

int run(const RepairCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<SurfaceFormat> format = surface_format_of(command.output);
  if (!format && !command.surface_only && tet_format_of(command.output)) {
    MeshCommand mesh;
    mesh.input = command.input, mesh.output = command.output, mesh.report = command.report;
    mesh.on_infeasible = "repair";
    mesh.max_move = command.max_move;
    return run(mesh, common, terminal);
  }
  if (!format) return fail(terminal, format.error());
  if (!command.report.empty())
    return fail(terminal, {ErrorCode::usage, "A report is written of a run that makes a tet mesh only."});
  if (command.input == command.output)
    return fail(terminal,
                {ErrorCode::usage, "The input would be overwritten; choose another name for the output."});
  OutputProbe output;
  if (Status s = output.open(command.output); !s) return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  const ScopedThreads threads(common.threads);
  Watchdog watchdog(context.deadline, context.memory_limit_bytes,
                    [&](const Error& error) { terminal.error(with_hint(error)); });
  const Result<Surface> surface = read_surface(command.input);
  if (!surface) return fail(terminal, surface.error());
  PipelineOptions options;
  options.on_infeasible = OnInfeasible::repair;
  options.max_repair_move = command.max_move / 100;
  options.improve_degrees = 0;
  const PipelineResult result = run_pipeline(surface.value(), options, context);
  watchdog.dismiss();
  if (!result.ok()) return fail(terminal, result.error);
  if (interrupt_flag()) return fail(terminal, {ErrorCode::interrupted, "Interrupted; nothing was written."});
  Surface repaired = surface.value();
  repaired.V = result.mesh.V.topRows(repaired.V.rows());
  if (Status s = write_surface(command.output, repaired, format.value()); !s)
    return fail(terminal, s.error());
  terminal.clear();
  const Report& r = result.report;
  char most[96];
  std::snprintf(most, sizeof most, "%.4f %% of the diagonal at most (%.4f in the mean).",
                100 * r.max_relative_move, 100 * r.mean_relative_move);
  terminal.say(command.output + ": " + std::to_string(r.moved_vertices) + " of " +
               std::to_string(repaired.V.rows()) + " vertices moved, by " + most + " It has a tet mesh.");
  return 0;
}

}  // namespace overtet
