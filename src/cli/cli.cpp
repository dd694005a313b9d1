#include "src/cli/cli.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <new>

#include "overtet/version.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"
#include "src/cli/tuning.h"

namespace overtet {

namespace {

LogLevel level_named(const std::string& name) {
  if (name == "error") return LogLevel::error;
  if (name == "info") return LogLevel::info;
  if (name == "debug") return LogLevel::debug;
  return LogLevel::warning;
}

void add_common(CLI::App& command, CommonOptions& o) {
  command.add_option("--threads", o.threads, "Threads to use (default: all cores)")
      ->check(CLI::Range(1, 4096));
  command.add_option("--time-limit", o.time_limit, "Seconds after which to give up (exit 6)")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--memory-limit", o.memory_limit,
                  "MiB that the program and its children may use together (exit 6; default: what is free)")
      ->check(CLI::PositiveNumber);
  command.add_flag("--quiet,-q", o.quiet, "Say nothing but errors");
  command.add_option("--log-level", o.log_level, "error, warning, info or debug")
      ->check(CLI::IsMember({"error", "warning", "info", "debug"}))
      ->capture_default_str();
}

CLI::App* add_mesh(CLI::App& app, MeshCommand& mesh) {
  CLI::App* command = app.add_subcommand("mesh", "Make a tet mesh of a surface");
  command->add_option("INPUT", mesh.input, "Surface: .obj, .off, .ply or .stl")->required();
  command->add_option("--output,-o", mesh.output, "Tet mesh: .mesh, .msh, .vtu, or .node (with .ele)")
      ->required();
  command
      ->add_option("--format", mesh.format,
                   "medit, msh22, msh41, vtu or tetgen (default: by the output's name)")
      ->check(CLI::IsMember({"medit", "msh22", "msh41", "vtu", "tetgen"}));
  command->add_option("--report", mesh.report, "Write a report (JSON), also when there is no mesh");
  command->add_option("--on-infeasible", mesh.on_infeasible, "reject or repair")
      ->check(CLI::IsMember({"reject", "repair"}))
      ->capture_default_str();
  command
      ->add_option(
          "--preset", mesh.preset,
          "default: without flows where that works; flow (or paper): flows and a volumetric map only")
      ->check(CLI::IsMember({"default", "flow", "paper"}))
      ->capture_default_str();
  command
      ->add_option("--improve", mesh.improve_degrees,
                   "Smallest dihedral angle to aim at, in degrees; 0: no quality pass")
      ->check(CLI::Range(0.0, 40.0))
      ->capture_default_str();
  command->add_option("--save-stages", mesh.save_stages, "Folder for the intermediate states");
  command->add_option("--resume", mesh.resume, "Folder of an earlier --save-stages to continue from");
  return command;
}

CLI::App* add_inspect(CLI::App& app, InspectCommand& inspect) {
  CLI::App* command =
      app.add_subcommand("inspect", "Say what a surface is like and whether it can be meshed");
  command->add_option("INPUT", inspect.input, "Surface: .obj, .off, .ply or .stl")->required();
  command->add_flag("--json", inspect.json, "As JSON");
  command->add_flag("--pairs", inspect.pairs, "List the intersecting pairs of faces");
  command->add_flag("--curves", inspect.curves,
                    "With --json: every point of the curves, with its two places on the surface");
  command->add_option("--save-curves", inspect.save_curves,
                      "Write the curves in which the surface crosses itself: .vtp or .obj");
  return command;
}

CLI::App* add_repair(CLI::App& app, RepairCommand& repair) {
  CLI::App* command = app.add_subcommand(
      "repair", "Move a few vertices of a surface a little, so that a tet mesh of it exists, and make that");
  command->add_option("INPUT", repair.input, "Surface: .obj, .off, .ply or .stl")->required();
  command
      ->add_option("--output,-o", repair.output,
                   "Tet mesh: .mesh, .msh, .vtu, .node or .ele; or the repaired surface: .off, .obj or .ply")
      ->required();
  command->add_flag("--surface-only", repair.surface_only, "Write the repaired surface, make no mesh");
  command->add_option("--report", repair.report, "Write a JSON report (with a tet mesh only)");
  command->add_option("--max-move", repair.max_move, "Largest move of a vertex, in percent of the diagonal")
      ->check(CLI::Range(1e-6, 100.0))
      ->capture_default_str();
  return command;
}

CLI::App* add_verify(CLI::App& app, VerifyCommand& verify) {
  CLI::App* command = app.add_subcommand("verify", "Check a tet mesh against its surface, exactly");
  command->add_option("SURFACE", verify.surface, "Surface: .obj, .off, .ply or .stl")->required();
  command->add_option("TETMESH", verify.mesh, "Tet mesh: .mesh, .msh, .vtu, .node or .ele")->required();
  command
      ->add_option("--max-move", verify.max_move,
                   "Allow surface vertices to have moved by this part of the diagonal")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--json", verify.json, "As JSON");
  return command;
}

int parse_and_run(int argc, char** argv) {
  CLI::App app(
      "Overtet makes tetrahedral meshes of closed triangle surfaces that pass through themselves: every "
      "input "
      "triangle is a boundary face, every tet is positive, and the mesh overlaps itself where the surface "
      "does.",
      "overtet");
  app.require_subcommand(1);
  app.set_version_flag("--version", "overtet " + version());
  app.footer(
      "Exit codes: 0 done, 2 usage, 3 bad input, 4 unsolved, 5 infeasible (a witness is in the report), "
      "6 time or memory limit, 7 I/O, 70 internal error, 130 interrupted.");

  CommonOptions common;
  MeshCommand mesh;
  InspectCommand inspect;
  RepairCommand repair;
  VerifyCommand verify;
  CLI::App* mesh_app = add_mesh(app, mesh);
  CLI::App* inspect_app = add_inspect(app, inspect);
  CLI::App* repair_app = add_repair(app, repair);
  CLI::App* verify_app = add_verify(app, verify);
  for (CLI::App* command : {mesh_app, inspect_app, repair_app, verify_app}) add_common(*command, common);

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);  // --help, --version
  } catch (const CLI::ParseError& e) {
    Terminal terminal(LogLevel::warning, Terminal::Talk::all);
    return fail(terminal, {ErrorCode::usage, std::string(e.what()) + " (see overtet --help)"});
  }
  Terminal terminal(common.quiet ? LogLevel::error : level_named(common.log_level),
                    common.quiet ? Terminal::Talk::errors_only : Terminal::Talk::all);
  install_signal_handlers();
  if (*mesh_app) return run(mesh, common, terminal);
  if (*inspect_app) return run(inspect, common, terminal);
  if (*repair_app) return run(repair, common, terminal);
  return run(verify, common, terminal);
}

}  // namespace

RunContext CommonOptions::context(Terminal& terminal) const {
  RunContext c;
  c.cancel = &interrupt_flag();
  // More than a century is no limit; it would overflow the clock.
  if (time_limit > 0 && time_limit < 4e9)
    c.deadline = start + std::chrono::duration_cast<RunContext::Clock::duration>(
                             std::chrono::duration<double>(time_limit));
  if (memory_limit == 0)
    c.memory_limit_bytes = static_cast<std::size_t>(kFreeMemory * static_cast<double>(usable_memory_bytes()));
  else if (memory_limit < 0x1p43)
    c.memory_limit_bytes = static_cast<std::size_t>(memory_limit * 0x1p20);
  c.threads = threads;
  c.progress = [&terminal](std::string_view stage, double fraction, std::string_view detail) {
    terminal.progress(stage, fraction, detail);
  };
  c.log = [&terminal](LogLevel level, std::string_view message) { terminal.log(level, message); };
  return c;
}

std::string with_hint(const Error& error) {
  const bool time = error.reason == ErrorReason::time_limit;
  if (!time && error.reason != ErrorReason::memory_limit) return error.message;
  std::string text = error.message;
  if (!text.empty() && text.back() == '.') text.pop_back();
  return text + "; allow more with " + (time ? "--time-limit." : "--memory-limit.");
}

int fail(Terminal& terminal, const Error& error) {
  terminal.error(with_hint(error));
  return static_cast<int>(error.code);
}

int run_command_line(int argc, char** argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("overtet: There is not enough memory.\n", stderr);
    return static_cast<int>(ErrorCode::limit);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "overtet: Internal error, please report it: %s.\n", e.what());
  } catch (...) {
    std::fputs("overtet: Internal error, please report it.\n", stderr);
  }
  return static_cast<int>(ErrorCode::internal);
}

}  // namespace overtet
