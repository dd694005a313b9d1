#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>
#include <utility>
#include <vector>

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
  std::string text = " The surface was repaired: " + std::to_string(r.moved_vertices) +
                     (r.moved_vertices == 1 ? " vertex" : " vertices") + " moved, by " +
                     plain(100 * r.max_relative_move, 4) + " % of its diagonal at most";
  if (const auto& a = r.moved_angles) {
    text += "; smallest dihedral angle there " + plain(a->least, 2) + " degrees";
    const double bound = std::min(a->bound, a->bound_as_moved);
    if (bound < 2 * a->least)
      text += a->bound < 2 * a->least ? ", where the untouched surface allows " + plain(a->bound, 2)
                                      : ", where the surface as it is now allows " + plain(bound, 2);
    if (a->bound_elsewhere < a->least)
      text += "; the untouched surface elsewhere allows " + plain(a->bound_elsewhere, 2);
  }
  return text + ".";
}

// The stages that took a twentieth or more of the time, the longest first.
std::string time_by_stage(const Report& r) {
  std::vector<std::pair<std::string, double>> sums;
  double rest = r.seconds;
  for (const StageRecord& s : r.stages) {
    const auto same =
        std::find_if(sums.begin(), sums.end(), [&](const auto& x) { return x.first == s.name; });
    (same == sums.end() ? sums.emplace_back(s.name, 0) : *same).second += s.seconds;
  }
  std::stable_sort(sums.begin(), sums.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (const auto& [name, seconds] : sums) {
    if (seconds < 0.05 * r.seconds) break;
    text += name + " " + plain(seconds, 1) + ", ";
    rest -= seconds;
  }
  return " (" + text + "the rest " + plain(std::max(0.0, rest), 1) + ")";
}

std::string what_was_made(const MeshCommand& c, const Meshing& m, const Report& report) {
  return c.output + ": " + std::to_string(m.mesh.V.rows()) + " vertices, " + std::to_string(m.mesh.T.rows()) +
         " tets, smallest dihedral angle " + plain(m.quality.dihedral_min, 2) + " degrees (" +
         plain(m.quality.dihedral_p01, 1) + " at 1 %), checked exactly, " + plain(report.seconds, 1) + " s" +
         (report.status == RunStatus::repaired ? time_by_stage(report) : std::string()) + "." +
         what_was_moved(report);
}

MeshingOptions meshing_options(const MeshCommand& c) {
  MeshingOptions o;
  o.preset = c.preset == "default" ? Preset::standard : Preset::flow;
  o.on_infeasible = c.on_infeasible == "repair" ? OnInfeasible::repair : OnInfeasible::reject;
  o.max_repair_move = c.max_move / 100;
  o.improve_degrees = c.improve_degrees;
  o.save_stages = c.save_stages;
  o.resume = c.resume;
  return o;
}

// What the program does itself, as a stage like the others.
template <class F>
auto timed(const char* name, StageRecord& record, F&& f) {
  const auto start = RunContext::Clock::now();
  const std::clock_t cpu = std::clock();
  auto result = f();
  record.name = name;
  record.seconds = std::chrono::duration<double>(RunContext::Clock::now() - start).count();
  record.cpu_seconds = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  return result;
}

// Reads, meshes and writes; `dismiss` is called when everything that takes long is over: a file that has its
// name already is not taken back. What there is to tell is in the report, whatever happens.
Result<Meshing> make_mesh(const MeshCommand& command, TetFormat format, const RunContext& context,
                          Terminal& terminal, const std::function<void()>& dismiss, Report& report) {
  context.report("read", 0);
  SurfaceReadInfo info;
  StageRecord read, written;
  const Result<Surface> surface =
      timed("read", read, [&] { return read_surface(command.input, &info, context); });
  if (!surface) {
    dismiss();
    report.stages = {read};
    report.input.format = info.format;
    report.input.notes = info.notes;
    return surface.error();
  }
  for (const std::string& note : info.notes) terminal.say(note);
  Result<Meshing> made = tetrahedralize(surface.value(), meshing_options(command), context, &report);
  report.stages.insert(report.stages.begin(), read);
  report.input.format = info.format;
  report.input.notes = info.notes;
  dismiss();
  if (!made) return made;
  if (interrupt_flag()) return Error{ErrorCode::interrupted, "Interrupted; nothing was written."};
  context.report("write", 0);
  if (Status s = timed("write", written,
                       [&] { return write_tets(command.output, made.value().mesh, format, context); });
      !s)
    return s.error();
  report.stages.push_back(written);
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
