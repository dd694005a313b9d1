#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <optional>

#include "kernels/parallel/parallel.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"
#include "src/io/file.h"
#include "src/io/surface_io.h"
#include "src/io/tet_io.h"
#include "src/pipeline/pipeline.h"

namespace overtet {

namespace {

bool same_file(const std::string& a, const std::string& b) {
  struct stat x, y;
  if (a.empty() || b.empty()) return false;
  if (a == b) return true;
  return ::stat(a.c_str(), &x) == 0 && ::stat(b.c_str(), &y) == 0 && S_ISREG(x.st_mode) &&
         x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

std::vector<Figure> options_of(const MeshCommand& c, const CommonOptions& common, TetFormat format) {
  static constexpr const char* names[] = {"medit", "msh22", "msh41", "vtu", "tetgen"};
  std::vector<Figure> o = {{"input", c.input},
                           {"output", c.output},
                           {"format", std::string(names[static_cast<int>(format)])},
                           {"preset", c.preset},
                           {"on_infeasible", c.on_infeasible},
                           {"improve", c.improve_degrees},
                           {"threads", std::int64_t{common.threads}}};
  if (common.time_limit > 0) o.emplace_back("time_limit", common.time_limit);
  if (common.memory_limit > 0) o.emplace_back("memory_limit", common.memory_limit);
  if (!c.save_stages.empty()) o.emplace_back("save_stages", c.save_stages);
  if (!c.resume.empty()) o.emplace_back("resume", c.resume);
  return o;
}

Status write_report(const std::string& path, const Report& report) {
  if (path.empty()) return success();
  AtomicFile file;
  if (Status s = file.open(path); !s) return s;
  if (Status s = file.write(to_json(report)); !s) return s;
  return file.commit();
}

std::string plain(double x, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", digits, x);
  return text;
}

std::string what_was_moved(const Report& r) {
  if (r.status != RunStatus::repaired) return {};
  return " The surface was repaired: " + std::to_string(r.moved_vertices) +
         (r.moved_vertices == 1 ? " vertex" : " vertices") + " moved, by " +
         plain(100 * r.max_relative_move, 4) + " % of its diagonal at most.";
}

std::string what_was_made(const MeshCommand& c, const PipelineResult& r, double seconds) {
  return c.output + ": " + std::to_string(r.mesh.V.rows()) + " vertices, " + std::to_string(r.mesh.T.rows()) +
         " tets, smallest dihedral angle " + plain(r.report.quality ? r.report.quality->dihedral_min : 0, 2) +
         " degrees (" + plain(r.report.quality ? r.report.quality->dihedral_p01 : 0, 1) +
         " at 1 %), checked exactly, " + plain(seconds, 1) + " s." + what_was_moved(r.report);
}

}  // namespace

int run(const MeshCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<TetFormat> format =
      command.format.empty() ? tet_format_of(command.output) : tet_format_named(command.format);
  if (!format) return fail(terminal, format.error());
  if (same_file(command.input, command.output) || same_file(command.input, command.report))
    return fail(terminal,
                {ErrorCode::usage, "The input would be overwritten; choose another name for the output."});
  if (same_file(command.output, command.report))
    return fail(terminal, {ErrorCode::usage, "The output and the report have the same name."});
  OutputProbe output, report;
  if (Status s = output.open(command.output); !s) return fail(terminal, s.error());
  if (!command.report.empty())
    if (Status s = report.open(command.report); !s) return fail(terminal, s.error());

  const RunContext context = common.context(terminal);
  const ScopedThreads threads(common.threads);
  PipelineResult result;
  result.report.options = options_of(command, common, format.value());
  const std::vector<Figure> options = result.report.options;
  const auto seconds = [&] {
    return std::chrono::duration<double>(RunContext::Clock::now() - common.start).count();
  };

  Watchdog watchdog(context.deadline, context.memory_limit_bytes, [&](const Error& error) {
    terminal.error(with_hint(error));
    if (error.code == ErrorCode::interrupted) return;
    Report late;  // what the stages were doing is theirs; this thread only knows the options
    late.options = options;
    late.status = status_of(error.code);
    late.message = with_hint(error);
    late.seconds = seconds();
    (void)write_report(command.report, late).ok();
  });

  context.report("read", 0);
  SurfaceReadInfo info;
  Result<Surface> surface = read_surface(command.input, &info);
  if (surface.ok()) {
    for (const std::string& note : info.notes) terminal.say(note);
    PipelineOptions o;
    o.preset = command.preset == "default" ? Preset::standard : Preset::flow;
    o.on_infeasible = command.on_infeasible == "repair" ? OnInfeasible::repair : OnInfeasible::reject;
    o.max_repair_move = command.max_move / 100;
    o.improve_degrees = command.improve_degrees;
    o.save_stages = command.save_stages;
    o.resume = command.resume;
    result = run_pipeline(surface.value(), o, context);
    result.report.options = options;
    if (!result.ok()) result.report.message = with_hint(result.error);
  } else {
    result.error = surface.error();
    result.report.status = status_of(result.error.code);
    result.report.message = result.error.message;
  }
  result.report.input.format = info.format;
  result.report.input.notes = info.notes;

  // From here on everything is quick, and a file that has its name already is not taken back.
  watchdog.dismiss();
  if (result.ok() && interrupt_flag()) {
    result.report.status = RunStatus::interrupted;
    result.error = {ErrorCode::interrupted, "Interrupted; nothing was written."};
  }
  if (result.ok()) {
    context.report("write", 0);
    if (Status s = write_tets(command.output, result.mesh, format.value()); !s) {
      result.error = s.error();
      result.report.status = RunStatus::failed;
      result.report.message = s.error().message;
    }
  }
  result.report.seconds = seconds();
  if (result.ok()) result.report.message = what_was_made(command, result, result.report.seconds);
  terminal.clear();
  const bool made = result.ok();
  if (result.report.status != RunStatus::interrupted) {
    if (Status s = write_report(command.report, result.report); !s) {
      if (made) return fail(terminal, s.error());
      terminal.error(s.error().message);
    }
  }
  if (!made) return fail(terminal, result.error);
  terminal.say(result.report.message);
  return 0;
}

}  // namespace overtet
