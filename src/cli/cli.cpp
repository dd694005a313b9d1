#include "src/cli/cli.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <new>
#include <utility>

#include "overtet/version.h"
#include "src/cli/arguments.h"
#include "src/cli/commands.h"
#include "src/cli/memory.h"
#include "src/cli/shell_help.h"
#include "src/cli/signals.h"
#include "src/cli/solve_options.h"
#include "src/cli/tuning.h"

namespace overtet {

namespace {

LogLevel level_named(const std::string& name) {
  if (name == "error") return LogLevel::error;
  if (name == "info") return LogLevel::info;
  if (name == "debug") return LogLevel::debug;
  return LogLevel::warning;
}

void add_messages(CLI::App& command, CommonOptions& o) {
  command.add_flag("--quiet,-q", o.quiet, "Print errors only");
  command.add_option("--log-level", o.log_level, "Which messages to print: error, warning, info or debug")
      ->check(CLI::IsMember({"error", "warning", "info", "debug"}))
      ->capture_default_str();
}

void add_common(CLI::App& command, CommonOptions& o) {
  command
      .add_option("--threads", o.threads,
                  "Number of threads (default: all cores); the result does not depend on it")
      ->check(between(1, 4096));
  command.add_option("--time-limit", o.time_limit, "Give up after this many seconds (exit 6)")
      ->check(more_than_zero());
  command
      .add_option("--memory-limit", o.memory_limit,
                  "MiB that the program and its child processes may use together (exit 6 if they need more; "
                  "default: 90 % of what is free)")
      ->check(more_than_zero());
  add_messages(command, o);
}

void add_cleaning(CLI::App& command, InputOptions& o) {
  command.add_flag(
      "--strict", o.strict,
      "Refuse a surface that needs a clean-up (equal corners merged, what is there twice or unused "
      "dropped, faces oriented alike, ...) instead of cleaning it");
  command.add_option(
      "--save-map", o.save_map,
      "Write the numbers that the vertices and faces of the cleaned surface have in the file: JSON");
  command.add_option("--save-cleaned", o.save_cleaned, "Write the cleaned surface: .off, .obj or .ply");
}

const char* surface_help() {
  return "Surface: .obj, .off, .ply, .stl, .glb, .gltf, .vtp, .vtk, .msh or .mesh; with .gz: compressed; -: "
         "standard input";
}
std::string tet_formats() { return "medit, msh22, msh41, vtu, tetgen, abaqus or vtk"; }
const std::vector<std::string> tet_format_names = {"medit",  "msh22",  "msh41", "vtu",
                                                   "tetgen", "abaqus", "vtk"};

void add_order(CLI::App* command, int& order) {
  command->add_option("--order", order, "2: tets with ten vertices, those in the middle of edges included")
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
}

void add_recipe(CLI::App* command, MeshCommand& mesh) {
  command
      ->add_option("--forward", mesh.forward,
                   "Of --preset paper: which vertices flow, global (all) or regional (near crossings)")
      ->check(CLI::IsMember({"global", "regional"}));
  command
      ->add_option("--reverse", mesh.reverse,
                   "Of --preset paper: what keeps faces apart on the way back, pins or a barrier")
      ->check(CLI::IsMember({"pins", "barrier"}));
  command
      ->add_option(
          "--map", mesh.map,
          "How the mesh of the embedding comes to the surface. Of --preset flow: patch (what has moved "
          "is made anew; the default) or pull (every tet positive on the way). Of --preset paper: lim "
          "(locally injective mappings; the default), arap (volumetric; may flip tets) or pull")
      ->check(CLI::IsMember({"patch", "pull", "lim", "arap"}));
  command->add_flag("--allow-branches", mesh.allow_branches,
                    "Of --preset paper: write a mesh with two turns around some edges inside, too");
  command->add_flag(
      "--allow-flips", mesh.allow_flips,
      "Of --preset paper: write a mesh with tets that are not positive, too; the exit code is 4 "
      "all the same");
}

CLI::App* add_mesh(CLI::App& app, MeshCommand& mesh) {
  CLI::App* command = app.add_subcommand("mesh", "Make a tet mesh of a surface");
  command->add_option("INPUT", mesh.input, surface_help())->required();
  command
      ->add_option(
          "--output,-o", mesh.output,
          "Tet mesh: .mesh, .msh, .vtu, .inp, .vtk, or .node (also writes .ele and .face); with .gz: "
          "compressed; -: standard output")
      ->required();
  command
      ->add_option("--format", mesh.format,
                   tet_formats() + " (default: by the extension of the output; .msh: msh41)")
      ->check(CLI::IsMember(tet_format_names));
  add_order(command, mesh.order);
  command->add_option("--report", mesh.report, "Write a JSON report to this file, even if no mesh is made");
  command
      ->add_option(
          "--on-infeasible", mesh.on_infeasible,
          "If no mesh exists: reject the surface; repair it by moving a few vertices; refine it: the "
          "same shape, a few faces subdivided; or branch: the tets make two turns around some edges "
          "inside")
      ->check(CLI::IsMember({"reject", "repair", "refine", "branch"}))
      ->capture_default_str();
  command
      ->add_option("--max-move", mesh.max_move,
                   "Largest move of a vertex in a repair, in percent of the diagonal of the bounding box")
      ->check(between(1e-6, 100))
      ->capture_default_str();
  command
      ->add_option(
          "--preset", mesh.preset,
          "default: the immersion route, then the others if that finds no mesh; flow: the flow route "
          "only; paper: the recipe of Sacht et al. 2013 to the letter, which often ends unsolved")
      ->check(CLI::IsMember({"default", "flow", "paper"}))
      ->capture_default_str();
  add_recipe(command, mesh);
  command
      ->add_option("--improve", mesh.improve_degrees,
                   "Smallest dihedral angle that the quality pass aims at, in degrees; 0: no quality pass "
                   "(default: 17, with --preset paper 0)")
      ->check(between(0, 40));
  command->add_option(
      "--save-surface", mesh.save_surface,
      "Write the surface that the mesh is of to this file, repaired or refined: .off, .obj or .ply");
  command
      ->add_option("--max-volume", mesh.sizes.max_volume,
                   "Largest volume of a tet, in the cube of the surface's unit")
      ->check(more_than_zero());
  command
      ->add_option("--max-edge", mesh.sizes.max_edge,
                   "Longest edge inside, in the surface's unit (edges of the surface stay as they are)")
      ->check(more_than_zero());
  command->add_option(
      "--size", mesh.sizes.file,
      "File with a number for each vertex of the surface: the longest edge inside there, 0 for any; "
      "edges grow with the distance from the surface");
  command->add_flag("--coarse", mesh.sizes.coarse,
                    "As few vertices inside as the angle of --improve (and the sizes) allow");
  command->add_option("--save-stages", mesh.save_stages, "Save the intermediate states in this folder");
  command->add_option(
      "--save-flow", mesh.save_flow,
      "Of --preset paper and flow: save every state of the flows in this folder, as a film for ParaView "
      "(flow.pvd)");
  command->add_option("--resume", mesh.resume,
                      "Continue from the states that --save-stages left in this folder");
  return command;
}

CLI::App* add_inspect(CLI::App& app, InspectCommand& inspect) {
  CLI::App* command = app.add_subcommand("inspect", "Describe a surface and say whether it can be meshed");
  command->add_option("INPUT", inspect.input, surface_help())->required();
  command->add_flag("--json", inspect.json, "Print JSON");
  command->add_flag("--pairs", inspect.pairs, "List the intersecting pairs of faces");
  command->add_flag("--curves", inspect.curves,
                    "List every point of the curves, with its two places on the surface");
  command->add_option("--save-curves", inspect.save_curves,
                      "Write the curves in which the surface crosses itself to this file: .vtp or .obj");
  command->add_option("--save-defects", inspect.clean.save_defects,
                      "Write the places of what is wrong or had to be cleaned up to this file: .vtp or .obj");
  command
      ->add_option("--places", inspect.clean.most_places,
                   "How many places of each kind of defect to list (--json) and to save")
      ->check(between(1, 1000000))
      ->capture_default_str();
  command
      ->add_option(
          "--fail-on", inspect.fail_on,
          "Exit with 5 if the surface is infeasible, with 3 if it is unclean (has defects, mended or "
          "not, or faces without area); without this, 3 only if it cannot be looked at")
      ->delimiter(',')
      ->check(CLI::IsMember({"infeasible", "unclean"}));
  command->footer(
      "Exit codes: 0 the surface was inspected (be it infeasible), 3 it is bad input, 5 it is infeasible and "
      "--fail-on says so.");
  return command;
}

CLI::App* add_repair(CLI::App& app, RepairCommand& repair) {
  CLI::App* command = app.add_subcommand(
      "repair", "Move a few vertices of a surface a little so that a tet mesh exists, and make that mesh");
  command->add_option("INPUT", repair.input, surface_help())->required();
  command
      ->add_option("--output,-o", repair.output,
                   "Tet mesh: .mesh, .msh, .vtu, .node or .ele; or the repaired surface: .off, .obj or .ply")
      ->required();
  command->add_flag("--surface-only", repair.surface_only,
                    "Write the repaired surface instead of a tet mesh");
  command->add_option("--report", repair.report,
                      "Write a JSON report to this file, even if the repair fails");
  command
      ->add_option("--max-move", repair.max_move,
                   "Largest move of a vertex, in percent of the diagonal of the bounding box")
      ->check(between(1e-6, 100))
      ->capture_default_str();
  return command;
}

CLI::App* add_embed(CLI::App& app, EmbedCommand& embed) {
  CLI::App* command = app.add_subcommand(
      "embed",
      "Make the same surface without crossings: nearly the same lengths and areas, no faces intersect");
  command->add_option("INPUT", embed.input, surface_help())->required();
  command
      ->add_option("--output,-o", embed.output,
                   "The embedding: .off, .obj, .ply or .vtp; with .gz: compressed. Its faces are the input's")
      ->required();
  command->add_option("--report", embed.report,
                      "Write a JSON report to this file, even if there is no embedding");
  command->add_flag("--json", embed.json, "Print the report");
  command->footer(
      "Components that cross each other are laid side by side first. Lengths and areas are measured: see "
      "\"embedding\" in the report.");
  return command;
}

// What the words say, as they come; read_steps() puts them together.
struct PrepareWords {
  double weld = 0, tolerance = 0, needle_angle = 0;
  Index remove_small = 0, fill_holes = 0;
  bool all = false, close_cracks = false, largest = false, collapse_needles = false;
};

void add_steps(CLI::App* command, PrepareWords& w) {
  command
      ->add_option("--weld", w.weld,
                   "Merge vertices along borders that are no farther apart than this, in percent of the "
                   "diagonal of the bounding box")
      ->check(between(1e-9, 10));
  command->add_flag("--close-cracks", w.close_cracks,
                    "Merge vertices along borders within the tolerance, and split edges there at vertices "
                    "beside them");
  command
      ->add_option("--remove-small", w.remove_small,
                   "Drop components with fewer faces than this (never the one with the largest area)")
      ->check(between(1, 2e9));
  command->add_flag("--largest", w.largest,
                    "Drop all components but the one with the largest area; its cavities, too");
  command
      ->add_option("--fill-holes", w.fill_holes,
                   "Fill holes of at most so many edges, smoothly; where a filling would cross or touch "
                   "something, the hole stays")
      ->check(between(3, 5000));
  command->add_flag("--collapse-needles", w.collapse_needles,
                    "Collapse or flip faces with a very small angle where that moves the surface by no more "
                    "than the tolerance and crosses nothing new");
  command->add_flag("--all", w.all,
                    "--close-cracks --remove-small 10 --fill-holes 100 --collapse-needles; each can be given "
                    "another number beside it");
  command
      ->add_option("--tolerance", w.tolerance,
                   "Of --close-cracks and --collapse-needles, in percent of the diagonal (default: 0.01)")
      ->check(between(1e-9, 10));
  command
      ->add_option("--needle-angle", w.needle_angle,
                   "A face with a smaller angle is a needle, in degrees (default: 1)")
      ->check(between(1e-3, 30));
}

PrepareOptions read_steps(const PrepareWords& w) {
  PrepareOptions o = w.all ? PrepareOptions::all() : PrepareOptions{};
  o.close_cracks = o.close_cracks || w.close_cracks;
  o.collapse_needles = o.collapse_needles || w.collapse_needles;
  o.largest = w.largest;
  if (w.weld > 0) o.weld = w.weld / 100;
  if (w.remove_small > 0) o.remove_small = w.remove_small;
  if (w.fill_holes > 0) o.fill_holes = w.fill_holes;
  if (w.tolerance > 0) o.tolerance = w.tolerance / 100;
  if (w.needle_angle > 0) o.needle_degrees = w.needle_angle;
  return o;
}

CLI::App* add_prepare(CLI::App& app, PrepareCommand& prepare, PrepareWords& words) {
  CLI::App* command = app.add_subcommand(
      "prepare", "Make a raw surface usable: close cracks, fill holes, drop specks, collapse needles");
  command->add_option("INPUT", prepare.input, surface_help())->required();
  command
      ->add_option("--output,-o", prepare.output,
                   "Prepared surface: .off, .obj or .ply; with .gz: compressed")
      ->required();
  add_steps(command, words);
  command->add_flag("--allow-crossings", prepare.options.allow_crossings, "Let fillings cross the surface");
  command->add_option("--report", prepare.report, "Write a JSON report to this file");
  command->add_option(
      "--save-map", prepare.save_map,
      "Write the numbers that the vertices and faces of the prepared surface have in the file "
      "(-1: new ones): JSON");
  command
      ->add_option("--places", prepare.options.most_places,
                   "How many of the places that a step left as they are to list in the report")
      ->check(between(1, 1000000))
      ->capture_default_str();
  command->footer(
      "The clean-up that changes no shape runs before and after each step. Steps run in the order above. "
      "What "
      "none of them names stays as it is, to the last bit.");
  return command;
}

CLI::App* add_verify(CLI::App& app, VerifyCommand& verify) {
  CLI::App* command = app.add_subcommand("verify", "Check a tet mesh against its surface, exactly");
  command->add_option("SURFACE", verify.surface, surface_help())->required();
  command->add_option("TETMESH", verify.mesh, "Tet mesh: .mesh, .msh, .vtu, .node, .inp or .vtk")->required();
  command
      ->add_option("--format", verify.format,
                   "Format of the tet mesh: " + tet_formats() + " (default: by its extension)")
      ->check(CLI::IsMember(tet_format_names));
  command
      ->add_option(
          "--max-move", verify.max_move,
          "Largest move to allow a vertex of the surface, in percent of the diagonal of the bounding box")
      ->check(between(0, 100))
      ->capture_default_str();
  command->add_flag("--allow-branches", verify.allow_branches,
                    "Allow interior edges around which the tets make two turns or more, and count them");
  command->add_flag("--json", verify.json, "Print JSON");
  return command;
}

CLI::App* add_convert(CLI::App& app, ConvertCommand& convert) {
  CLI::App* command = app.add_subcommand(
      "convert", "Write a tet mesh in another format, with its labels and to the last bit");
  command
      ->add_option("INPUT", convert.input,
                   "Tet mesh: .mesh, .msh, .vtu, .node, .inp or .vtk; -: standard input")
      ->required();
  command->add_option("OUTPUT", convert.output, "Tet mesh, of these formats; -: standard output")->required();
  command
      ->add_option("--from", convert.from,
                   "Format of the input: " + tet_formats() + " (default: by its extension or contents)")
      ->check(CLI::IsMember(tet_format_names));
  command
      ->add_option("--format", convert.format,
                   "Format of the output (default: by its extension; .msh: msh41)")
      ->check(CLI::IsMember(tet_format_names));
  add_order(command, convert.order);
  return command;
}

CLI::App* add_view(CLI::App& app, ViewCommand& view) {
  CLI::App* command =
      app.add_subcommand("view", "Show a tet mesh or a surface: as a page for any browser, or as a picture");
  command->add_option("FILE", view.input, "Tet mesh (.mesh, .msh, .vtu, .node, .inp, .vtk) or surface")
      ->required();
  CLI::Option* page =
      command->add_option("--output,-o", view.page, "The page: one .html file that needs nothing else");
  command->add_flag("--open", view.open, "Open the page in the browser when it is written")->needs(page);
  CLI::Option* picture = command->add_option("--png", view.picture, "A picture: a PNG file");
  command->add_option("--size", view.size, "Of the picture, in pixels (default: 1200x900)")->needs(picture);
  command
      ->add_option("--eye", view.eye,
                   "Of the picture: the direction from the mesh to the eye, as X,Y,Z (default: .9,.8,3.4, or "
                   "one from which the cut is seen)")
      ->needs(picture);
  command
      ->add_option("--cut", view.cut,
                   "Of the picture: a cutting plane across x, y or z; with =SHARE (0 to 1, else .5) of the "
                   "way through the mesh. What lies beyond it is left out")
      ->needs(picture);
  command
      ->add_option("--colour", view.colouring,
                   "Of the picture: layers (how often the solid is there), label (of the boundary), region, "
                   "angle (the smallest dihedral one of a tet) or plain (default: the first that there is)")
      ->check(CLI::IsMember({"layers", "label", "region", "angle", "plain"}))
      ->needs(picture);
  command->add_option("--apart", view.apart, "Of the picture: how far layers are pulled apart, 0 to 1")
      ->check(between(0, 1))
      ->needs(picture);
  command->footer(
      "What overlaps is seen with \"Pull layers apart\", or --apart. Surfaces are drawn with the curves in "
      "which they cross themselves, and their hinges. Pictures are drawn by overtet-picture (package "
      "overtet-pictures) without a display.");
  return command;
}

CLI::App* add_compare(CLI::App& app, CompareCommand& compare) {
  CLI::App* command = app.add_subcommand(
      "compare", "Make the mesh that others make, to compare with: what overlaps is fused in it");
  command->add_option("INPUT", compare.input, surface_help())->required();
  command
      ->add_flag("--fused", compare.fused,
                 "The mesh of all places that the surface winds around a positive number of times")
      ->required();
  command->add_option("--output,-o", compare.output, "The fused mesh; formats as of overtet mesh")
      ->required();
  command->add_flag("--json", compare.json, "Print JSON");
  command->footer(
      "Faces are cut where they cross others. Fields, distances and elastic bodies (overtet solve) on this "
      "mesh pass from one part of the surface to another where these overlap; on the mesh of overtet mesh "
      "they do not.");
  return command;
}

CLI::App* add_batch(CLI::App& app, BatchCommand& batch, CommonOptions& common) {
  CLI::App* command = app.add_subcommand(
      "batch", "Mesh many surfaces, each in a process of its own, and keep a journal that can be resumed");
  command
      ->add_option(
          "MODELS", batch.models,
          "Folder of surfaces (all below it count), or manifest: a text file with a path a line; with "
          "--summary: folders of results, or journals")
      ->required();
  command->add_option(
      "--output,-o", batch.folder,
      "Folder of the results: for each model NAME.mesh (or what --format says) and NAME.json, its "
      "report; and journal.jsonl");
  command
      ->add_option(
          "--jobs", batch.jobs,
          "Models at a time (default: as many as there are cores; affinity, CPU quotas of control groups "
          "and SLURM_CPUS_PER_TASK are respected)")
      ->check(between(1, 4096));
  command
      ->add_option(
          "--threads-per-job", batch.threads_per_job,
          "Threads for each (default: one; more for a model that is much of what is left, and where there "
          "are fewer jobs than cores)")
      ->check(between(1, 4096));
  command->add_option("--time-limit", common.time_limit, "Seconds for each model")->check(more_than_zero());
  command
      ->add_option(
          "--memory-limit", common.memory_limit,
          "MiB for each model (default: its share of 90 % of what is free; what needs more is tried again "
          "at the end, alone, with all of it)")
      ->check(more_than_zero());
  command->add_flag(
      "--resume", batch.resume,
      "Skip what the journals in the folder have: same contents, options and version, and the result is "
      "there");
  command->add_option(
      "--shard", batch.shard,
      "I/N: do part I (from 1) of N parts; together they do all, each on a machine of its own or not");
  command->add_option("--format", batch.format, tet_formats() + " (default: medit)")
      ->check(CLI::IsMember(tet_format_names));
  command->add_option("--report", batch.report,
                      "Write a summary of the folder's journals to this file at the end: JSON");
  command->add_flag(
      "--summary", batch.summary,
      "Mesh nothing: print what the journals of these folders say, and write the tables asked for");
  command->add_option("--csv", batch.csv, "With --summary: a row a model");
  command->add_option("--json", batch.json, "With --summary: totals and all entries");
  command->add_option("--html", batch.html, "With --summary: one page with histograms and a table");
  add_messages(*command, common);
  command->footer(
      "What stands after -- goes to overtet mesh, for each model: overtet batch DIR -o OUT -- --improve 20. "
      "There "
      "{name} is the name of the model's results, without an ending.\n"
      "Exit codes: 0 every model has an answer (whatever it is), 2 usage, 7 the journal or a result cannot "
      "be "
      "written, or a model cannot be read, 70 a model crashed, 130 or 143 interrupted (go on with "
      "--resume).");
  return command;
}

// What stands after -- is not ours: it is taken away here.
std::vector<std::string> words_for_mesh(std::vector<std::string>& words) {
  if (words.empty() || words[0] != "batch") return {};
  const auto dashes = std::find(words.begin(), words.end(), "--");
  if (dashes == words.end()) return {};
  std::vector<std::string> after(dashes + 1, words.end());
  words.erase(dashes, words.end());
  return after;
}

// All that can be asked for, and what does it. More than 12 members: the commands, one by one.
struct CommandLine {
  CommonOptions common;
  MeshCommand mesh;
  InspectCommand inspect;
  RepairCommand repair;
  EmbedCommand embed;
  PrepareCommand prepare;
  PrepareWords prepare_words;
  VerifyCommand verify;
  ConvertCommand convert;
  ViewCommand view;
  SolveCommand solve;
  CompareCommand compare;
  BatchCommand batch;
  std::string manual, shell;
  std::vector<std::pair<const CLI::App*, std::function<int(Terminal&)>>> commands;
};

int print(const Result<std::string>& text, Terminal& terminal) {
  if (!text) return fail(terminal, text.error());
  const bool printed = std::fputs(text.value().c_str(), stdout) >= 0 && std::fflush(stdout) == 0;
  return printed ? 0 : fail(terminal, {ErrorCode::io, "Cannot write standard output."});
}

int run_prepare(CommandLine& line, Terminal& terminal) {
  const PrepareOptions given = line.prepare.options;
  line.prepare.options = read_steps(line.prepare_words);
  line.prepare.options.allow_crossings = given.allow_crossings;
  line.prepare.options.most_places = given.most_places;
  return run(line.prepare, line.common, terminal);
}

// In the order in which the help lists them.
void add_commands(CLI::App& app, CommandLine& line) {
  const auto does = [&](CLI::App* command, std::function<int(Terminal&)> action) {
    line.commands.emplace_back(command, std::move(action));
    return command;
  };
  const auto runs = [&](CLI::App* command, const auto& options) {
    add_common(*command, line.common);
    return does(command, [&line, &options](Terminal& t) { return run(options, line.common, t); });
  };
  add_cleaning(*runs(add_mesh(app, line.mesh), line.mesh), line.mesh.clean);
  add_cleaning(*runs(add_inspect(app, line.inspect), line.inspect), line.inspect.clean);
  add_cleaning(*runs(add_repair(app, line.repair), line.repair), line.repair.clean);
  add_cleaning(*runs(add_embed(app, line.embed), line.embed), line.embed.clean);
  CLI::App* prepare = add_prepare(app, line.prepare, line.prepare_words);
  add_common(*prepare, line.common);
  does(prepare, [&line](Terminal& t) { return run_prepare(line, t); });
  runs(add_verify(app, line.verify), line.verify)
      ->add_flag("--strict", line.verify.clean.strict, "Refuse a surface that needs a clean-up");
  runs(add_convert(app, line.convert), line.convert);
  runs(add_view(app, line.view), line.view);
  runs(add_solve(app, line.solve), line.solve);
  add_cleaning(*runs(add_compare(app, line.compare), line.compare), line.compare.clean);
  does(add_batch(app, line.batch, line.common),
       [&line](Terminal& t) { return run(line.batch, line.common, t); });
  CLI::App* manual = app.add_subcommand("manual", "Print a man page: of a command, or of the program");
  manual->add_option("COMMAND", line.manual, "A command");
  does(manual, [&](Terminal& t) { return print(manual_of(app, line.manual), t); });
  CLI::App* completion = app.add_subcommand("completion", "Print a script that completes command lines");
  completion->add_option("SHELL", line.shell, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  does(completion, [&](Terminal& t) { return print(completion_for(line.shell, app), t); });
}

int parse_and_run(int argc, char** argv) {
  CLI::App app(
      "Overtet makes tetrahedral meshes of closed triangle surfaces that pass through themselves: every "
      "input triangle is a boundary face, every tet is positive, and the mesh overlaps itself where the "
      "surface does.",
      "overtet");
  app.require_subcommand(1);
  app.set_version_flag("--version", "overtet " + version());
  app.footer(
      "overtet FILE -o OUTPUT is short for overtet mesh; overtet help COMMAND explains one.\n"
      "Exit codes: 0 done, 2 usage, 3 bad input, 4 unsolved (verify: the mesh is wrong), 5 infeasible (the "
      "report has a witness), 6 time or memory limit, 7 a file cannot be read or written, 70 internal error, "
      "130 interrupted (143 by SIGTERM, 129 by SIGHUP).");
  CommandLine line;
  add_commands(app, line);

  std::vector<std::string> given(argv + 1, argv + argc);
  line.batch.mesh_options = words_for_mesh(given);
  Result<std::vector<std::string>> words = understood(std::move(given), app);
  Terminal complaints(LogLevel::warning, Terminal::Talk::all);
  if (!words) return fail(complaints, words.error());
  try {
    std::reverse(words.value().begin(), words.value().end());  // as CLI11 wants them
    app.parse(std::move(words).value());
  } catch (const CLI::Success& e) {
    return app.exit(e);  // --help, --version
  } catch (const CLI::ExtrasError&) {
    const std::vector<std::string> extra = app.remaining(true);
    return fail(complaints,
                {ErrorCode::usage, "There is one argument too many: " +
                                       (extra.empty() ? "see overtet --help" : extra.front()) + "."});
  } catch (const CLI::ParseError& e) {
    return fail(complaints, {ErrorCode::usage, std::string(e.what()) + " (see overtet --help)."});
  }
  const CommonOptions& common = line.common;
  Terminal terminal(common.quiet ? LogLevel::error : level_named(common.log_level),
                    common.quiet ? Terminal::Talk::errors_only : Terminal::Talk::all);
  const auto chosen = std::find_if(line.commands.begin(), line.commands.end(),
                                   [](const auto& command) { return command.first->parsed(); });
  return chosen->second(terminal);
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
  c.threads = threads > 0 ? threads : usable_cores();
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
  terminal.error(with_hint(explained(error)));
  return exit_code(error.code);
}

int fail(Watchdog& watchdog, Terminal& terminal, const Error& error) {
  watchdog.settle(error.code);
  return fail(terminal, error);
}

namespace {

// Says what the exception that is being handled means, and gives the exit code for it.
int last_error() {
  try {
    const Error error = explained(error_of_exception());
    std::fprintf(stderr, "overtet: %s\n", with_hint(error).c_str());
    return exit_code(error.code);
  } catch (...) {
    end_for_memory();
  }
}

}  // namespace

int run_command_line(int argc, char** argv) {
  install_memory_handlers();
  int code = 0;
  try {
    install_signal_handlers();
    code = parse_and_run(argc, argv);
  } catch (...) {
    code = last_error();
  }
  leaving();
  return code;
}

}  // namespace overtet
