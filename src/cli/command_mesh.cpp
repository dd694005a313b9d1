#include <cstdio>
#include <functional>

#include "overtet/io.h"
#include "overtet/meshing.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

std::vector<Figure> options_of(const MeshCommand& c, const CommonOptions& common, TetFormat format) {
  std::vector<Figure> o = {{"input", c.input},
                           {"output", c.output},
                           {"format", std::string(name_of(format))},
                           {"preset", c.preset},
                           {"on_infeasible", c.on_infeasible},
                           {"improve", c.improve_degrees},
                           {"order", std::int64_t{c.order}},
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
  Result<Meshing> made = tetrahedralize(surface.value(), meshing_options(command), context, &report);
  report.input.format = info.format;
  report.input.notes = info.notes;
  if (!made) {
    dismiss();
    return made;
  }
  if (interrupt_flag()) return Error{ErrorCode::interrupted, "Interrupted; nothing was written."};
  context.report("label", 0);
  const TetMesh& mesh = made.value().mesh;
  const MeshAttributeOptions wanted{keeps_layers(format)};
  const Result<MeshAttributes> attributes =
      mesh_attributes(surface.value(), info.attributes, mesh, wanted, context);
  dismiss();
  if (!attributes) return attributes.error();
  context.report("write", 0);
  if (Status s = write_tets(command.output, mesh, attributes.value(), {format, command.order}, context); !s)
    return s.error();
  return made;
}

// No file is to be written over another one.
Status check_names(const MeshCommand& command, const std::vector<std::string>& outputs) {
  if (same_file(command.input, command.report))
    return Error{ErrorCode::usage, "The report would overwrite the input; choose another name."};
  for (const std::string& output : outputs) {
    if (same_file(command.input, output))
      return Error{ErrorCode::usage, "The output would overwrite the input; choose another name."};
    if (same_file(output, command.report))
      return Error{ErrorCode::usage,
                   "The output and the report have the same name; choose another for one of them."};
  }
  return success();
}

}  // namespace

int run(const MeshCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<TetFormat> format = output_format(command.output, command.format, terminal);
  if (!format) return fail(terminal, format.error());
  const std::vector<std::string> outputs = tet_files(command.output, format.value());
  if (Status s = check_names(command, outputs); !s) return fail(terminal, s.error());
  std::vector<OutputProbe> output_probes(outputs.size());
  OutputProbe report_probe;
  for (std::size_t i = 0; i < outputs.size(); ++i)
    if (Status s = output_probes[i].open(outputs[i]); !s) return fail(terminal, s.error());
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
