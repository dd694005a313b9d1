#include <cstdio>

#include "overtet/io.h"
#include "overtet/repair.h"
#include "src/cli/commands.h"
#include "src/cli/memory.h"
#include "src/cli/signals.h"
#include "src/cli/stage_trail.h"

namespace overtet {

namespace {

std::string what_was_moved(const RepairCommand& command, const SurfaceRepair& r) {
  char most[96];
  std::snprintf(most, sizeof most, "%.4f %% of the diagonal at most (%.4f on average).",
                100 * r.max_relative_move, 100 * r.mean_relative_move);
  return command.output + ": " + std::to_string(r.moved.size()) + " of " +
         std::to_string(r.surface.V.rows()) + " vertices moved, by " + most + " The surface has a tet mesh.";
}

// Reads, repairs and writes the surface.
Result<SurfaceRepair> repaired_surface(const RepairCommand& command, SurfaceFormat format,
                                       const RunContext& context, Terminal& terminal, Watchdog& watchdog,
                                       Report& report) {
  const Result<InputSurface> loaded = load(command.input, command.clean, context, terminal);
  if (!loaded) return loaded.error();
  const InputSurface& input = loaded.value();
  Result<SurfaceRepair> repaired = Error{};
  if (input.cleanup.problem) {
    repaired = *input.cleanup.problem;
  } else {
    SurfaceRepairOptions options;
    options.max_relative_move = command.max_move / 100;
    repaired = repair_surface(input.surface(), options, context, &report);
  }
  tell(input, report);
  if (!repaired) return input.in_file(repaired.error());
  if (Status s = write_surface(command.output, repaired.value().surface, format, watchdog.writing(context),
                               &input.attributes.faces);
      !s)
    return s.error();
  return repaired;
}

// Quality and hash are those of the mesh that shows that there is one.
void finish(Report& report, const RepairCommand& command, const CommonOptions& common,
            const Result<SurfaceRepair>& repaired) {
  report.options = {{"input", command.input},
                    {"output", command.output},
                    {"max_move", command.max_move},
                    {"threads", std::int64_t{common.threads}}};
  if (common.time_limit > 0) report.options.emplace_back("time_limit", common.time_limit);
  if (common.memory_limit > 0) report.options.emplace_back("memory_limit", common.memory_limit);
  report.seconds = std::chrono::duration<double>(RunContext::Clock::now() - common.start).count();
  report.message = repaired ? what_was_moved(command, repaired.value()) : with_hint(repaired.error());
  if (!repaired) report.status = status_of(repaired.error().code);
}

}  // namespace

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
  if (Status s = check_names(command.input, command.output, command.report); !s)
    return fail(terminal, s.error());
  OutputAndReport probes;
  if (Status s = probes.open(command.output, command.report); !s) return fail(terminal, s.error());
  StageTrail trail;
  const RunContext context = trail.follow(common.context(terminal));
  Watchdog watchdog(context, common.start, [&](const Error& error) {
    terminal.last_words(with_hint(error));
    if (error.code == ErrorCode::interrupted || command.report.empty()) return;
    Report late;
    late.stages = trail.records();
    finish(late, command, common, error);
    (void)write_text(command.report, to_json(late)).ok();
  });
  Report report;
  Result<SurfaceRepair> repaired =
      caught([&] { return repaired_surface(command, format.value(), context, terminal, watchdog, report); });
  if (!repaired) repaired = explained(repaired.error());
  if (!repaired) watchdog.settle(repaired.error().code);
  finish(report, command, common, repaired);
  terminal.clear();
  const bool interrupted = !repaired && repaired.error().code == ErrorCode::interrupted;
  if (!command.report.empty() && !interrupted)
    if (Status s = write_text(command.report, to_json(report)); !s) {
      if (repaired) return fail(terminal, s.error());
      terminal.error(s.error().message);
    }
  if (!repaired) return fail(terminal, repaired.error());
  terminal.say(report.message);
  return 0;
}

}  // namespace overtet
