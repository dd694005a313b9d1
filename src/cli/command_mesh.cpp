#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <functional>

#include "overtet/io.h"
#include "overtet/meshing.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"

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
  if (c.sizes.max_volume > 0) o.emplace_back("max_volume", c.sizes.max_volume);
  if (c.sizes.max_edge > 0) o.emplace_back("max_edge", c.sizes.max_edge);
  if (!c.sizes.file.empty()) o.emplace_back("size", c.sizes.file);
  if (c.sizes.coarse) o.emplace_back("coarse", true);
  if (!c.save_stages.empty()) o.emplace_back("save_stages", c.save_stages);
  if (!c.resume.empty()) o.emplace_back("resume", c.resume);
  return o;
}

Status write_report(const std::string& path, const Report& report) {
  return path.empty() ? success() : write_text(path, to_json(report));
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

std::string what_was_made(const MeshCommand& c, const Meshing& m, const Report& report) {
  return c.output + ": " + std::to_string(m.mesh.V.rows()) + " vertices, " + std::to_string(m.mesh.T.rows()) +
         " tets, smallest dihedral angle " + plain(m.quality.dihedral_min, 2) + " degrees (" +
         plain(m.quality.dihedral_p01, 1) + " at 1 %), checked exactly, " + plain(report.seconds, 1) + " s." +
         what_was_moved(report);
}

MeshingOptions meshing_options(const MeshCommand& c) {
  MeshingOptions o;
  o.preset = c.preset == "default" ? Preset::standard : Preset::flow;
  o.on_infeasible = c.on_infeasible == "repair" ? OnInfeasible::repair : OnInfeasible::reject;
  o.max_repair_move = c.max_move / 100;
  o.improve_degrees = c.improve_degrees;
  o.sizes.max_volume = c.sizes.max_volume;
  o.sizes.max_edge = c.sizes.max_edge;
  o.sizes.coarse = c.sizes.coarse;
  o.save_stages = c.save_stages;
  o.resume = c.resume;
  return o;
}

// Reads, meshes and writes; `dismiss` is called when everything that takes long is over: a file that has its
// name already is not taken back. What there is to tell is in the report, whatever happens.
Result<Meshing> make_mesh(const MeshCommand& command, TetFormat format, const RunContext& context,
                          Terminal& terminal, const std::function<void()>& dismiss, Report& report) {
  context.report("read", 0);
  SurfaceReadInfo info;
  const Result<Surface> surface = read_surface(command.input, &info, context);
  if (!surface) {
    dismiss();
    report.input.format = info.format;
    report.input.notes = info.notes;
    return surface.error();
  }
  for (const std::string& note : info.notes) terminal.say(note);
  MeshingOptions options = meshing_options(command);
  if (!command.sizes.file.empty()) {
    Result<std::vector<double>> sizes = read_sizes(command.sizes.file);
    if (!sizes) {
      dismiss();
      report.input.format = info.format;
      report.input.notes = info.notes;
      return sizes.error();
    }
    options.sizes.at_vertex = std::move(sizes).value();
  }
  Result<Meshing> made = tetrahedralize(surface.value(), options, context, &report);
  report.input.format = info.format;
  report.input.notes = info.notes;
  dismiss();
  if (!made) return made;
  if (interrupt_flag()) return Error{ErrorCode::interrupted, "Interrupted; nothing was written."};
  context.report("write", 0);
  if (Status s = write_tets(command.output, made.value().mesh, format, context); !s) return s.error();
  return made;
}

}  // namespace

int run(const MeshCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<TetFormat> format =
      command.format.empty() ? tet_format_of(command.output) : tet_format_named(command.format);
  if (!format) return fail(terminal, format.error());
  if (same_file(command.input, command.output) || same_file(command.input, command.report))
    return fail(terminal, {ErrorCode::usage,
                           "The output or the report would overwrite the input; choose another name."});
  if (same_file(command.output, command.report))
    return fail(terminal, {ErrorCode::usage,
                           "The output and the report have the same name; choose another for one of them."});
  OutputProbe output_probe, report_probe;
  if (Status s = output_probe.open(command.output); !s) return fail(terminal, s.error());
  if (!command.report.empty())
    if (Status s = report_probe.open(command.report); !s) return fail(terminal, s.error());

  const RunContext context = common.context(terminal);
  const std::vector<Figure> options = options_of(command, common, format.value());
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

  Report report;
  const Result<Meshing> made = make_mesh(
      command, format.value(), context, terminal, [&] { watchdog.dismiss(); }, report);
  report.options = options;
  report.seconds = seconds();
  if (!made) report.status = status_of(made.error().code);
  report.message = made ? what_was_made(command, made.value(), report) : with_hint(made.error());
  if (!made && made.error().code == ErrorCode::infeasible && command.on_infeasible == "reject")
    report.message += " --on-infeasible repair moves vertices, as little as it can, until there is a mesh.";
  terminal.clear();
  if (report.status != RunStatus::interrupted) {
    if (Status s = write_report(command.report, report); !s) {
      if (made) return fail(terminal, s.error());
      terminal.error(s.error().message);
    }
  }
  if (!made) {
    terminal.error(report.message);
    return static_cast<int>(made.error().code);
  }
  terminal.say(report.message);
  return 0;
}

}  // namespace overtet
