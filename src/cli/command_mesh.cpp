#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <functional>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "overtet/attributes.h"
#include "overtet/io.h"
#include "overtet/meshing.h"
#include "src/cli/commands.h"
#include "src/cli/memory.h"
#include "src/cli/signals.h"
#include "src/cli/stage_trail.h"

namespace overtet {

namespace {

// The paper has no quality pass.
double improve_degrees(const MeshCommand& c) {
  return c.improve_degrees.value_or(c.preset == "paper" ? 0 : MeshingOptions().improve_degrees);
}

std::vector<Figure> options_of(const MeshCommand& c, const CommonOptions& common, TetFormat format) {
  std::vector<Figure> o = {{"input", c.input},
                           {"output", c.output},
                           {"format", std::string(name_of(format))},
                           {"preset", c.preset},
                           {"on_infeasible", c.on_infeasible},
                           {"improve", improve_degrees(c)},
                           {"order", std::int64_t{c.order}},
                           {"threads", std::int64_t{common.threads}}};
  for (const auto& [name, piece] :
       {std::pair{"forward", &c.forward}, {"reverse", &c.reverse}, {"map", &c.map}})
    if (!piece->empty()) o.emplace_back(name, *piece);
  if (c.allow_branches) o.emplace_back("allow_branches", true);
  if (c.allow_flips) o.emplace_back("allow_flips", true);
  if (common.time_limit > 0) o.emplace_back("time_limit", common.time_limit);
  if (common.memory_limit > 0) o.emplace_back("memory_limit", common.memory_limit);
  if (!c.save_surface.empty()) o.emplace_back("save_surface", c.save_surface);
  if (c.sizes.max_volume > 0) o.emplace_back("max_volume", c.sizes.max_volume);
  if (c.sizes.max_edge > 0) o.emplace_back("max_edge", c.sizes.max_edge);
  if (!c.sizes.file.empty()) o.emplace_back("size", c.sizes.file);
  if (c.sizes.coarse) o.emplace_back("coarse", true);
  if (!c.save_stages.empty()) o.emplace_back("save_stages", c.save_stages);
  if (!c.save_flow.empty()) o.emplace_back("save_flow", c.save_flow);
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

std::string counted(std::size_t n, const char* one, const char* many = nullptr) {
  return std::to_string(n) + " " + (n == 1 ? one : many ? many : std::string(one) + "s");
}

// What would do where there is no mesh, as far as that is known without trying.
std::string what_may_help(const MeshCommand& c, const Error& e) {
  if (e.reason == ErrorReason::exhausted && c.on_infeasible == "reject")
    return " With vertices moved, faces subdivided or branch lines inside there may be one: --on-infeasible "
           "repair, refine or branch.";
  if (e.code != ErrorCode::infeasible || c.on_infeasible == "repair") return {};
  const std::string repair =
      " --on-infeasible repair moves vertices, as little as it can, until there is a mesh.";
  if (c.on_infeasible != "reject" || !e.certificate) return repair;
  if (forbids_branch_lines(*e.certificate))
    return repair + " Subdividing faces (refine) or branch lines (branch) would not help.";
  return repair +
         " Without moving any, refine (a few faces subdivided) or branch (two turns around some edges "
         "inside) may do: not ruled out, and known when it has been tried.";
}

std::string what_was_changed(const MeshCommand& c, const Report& r) {
  if (r.status == RunStatus::refined)
    return " The surface was refined: " + counted(r.subdivided_faces.size(), "face") + " of " +
           std::to_string(r.input.faces) + " subdivided, " +
           counted(static_cast<std::size_t>(r.added_vertices), "vertex", "vertices") +
           " added; its shape is the same" + (c.save_surface.empty() ? " (--save-surface writes it)." : ".");
  if (r.status == RunStatus::branched)
    return " The surface is as it was; around " + counted(r.branch_edges.size(), "interior edge") +
           " the tets make two turns or more (the report lists them; overtet verify --allow-branches).";
  if (r.status == RunStatus::flipped)
    return " " + counted(r.flipped_tets.size(), "tet is", "tets are") + " not positive, of " +
           std::to_string(r.quality ? r.quality->tets : 0) +
           ": this is not a mesh that solvers can use (the report lists them; overtet verify says R4).";
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

// A text file of millions of tets takes its reader longer than the mesh took.
std::string what_reads_faster(const Meshing& m, TetFormat format) {
  const std::int64_t many = 2'000'000;
  if (m.mesh.T.rows() < many || format == TetFormat::vtu) return {};
  return " As text, so many tets are slow to read: an output that ends in .vtu is binary.";
}

std::string what_was_made(const MeshCommand& c, const Meshing& m, const Report& report) {
  return c.output + ": " + std::to_string(m.mesh.V.rows()) + " vertices, " + std::to_string(m.mesh.T.rows()) +
         " tets, smallest dihedral angle " + plain(m.quality.dihedral_min, 2) + " degrees (" +
         plain(m.quality.dihedral_p01, 1) + " at 1 %), " +
         (report.status == RunStatus::flipped ? "NOT exact, " : "checked exactly, ") +
         plain(report.seconds, 1) + " s" +
         (report.status == RunStatus::repaired ? time_by_stage(report) : std::string()) + "." +
         what_was_changed(c, report);
}

MeshingOptions meshing_options(const MeshCommand& c) {
  MeshingOptions o;
  o.preset = c.preset == "default" ? Preset::standard : c.preset == "flow" ? Preset::flow : Preset::paper;
  if (c.forward == "regional") o.recipe.forward = PaperRecipe::Forward::regional;
  if (c.reverse == "barrier") o.recipe.reverse = PaperRecipe::Reverse::barrier;
  if (c.map == "arap") o.recipe.map = PaperRecipe::Map::arap;
  if (c.map == "pull") o.recipe.map = PaperRecipe::Map::pull, o.flow_map = FlowMap::pull;
  o.allow_branches = c.allow_branches;
  o.allow_flips = c.allow_flips;
  o.on_infeasible = c.on_infeasible == "repair"   ? OnInfeasible::repair
                    : c.on_infeasible == "refine" ? OnInfeasible::refine
                    : c.on_infeasible == "branch" ? OnInfeasible::branch
                                                  : OnInfeasible::reject;
  o.max_repair_move = c.max_move / 100;
  o.improve_degrees = improve_degrees(c);
  o.sizes.max_volume = c.sizes.max_volume;
  o.sizes.max_edge = c.sizes.max_edge;
  o.sizes.coarse = c.sizes.coarse;
  o.save_stages = c.save_stages;
  o.save_flow = c.save_flow;
  o.resume = c.resume;
  return o;
}

struct LabelledSurface {
  Surface surface;
  SurfaceAttributes attributes;
};

// What the mesh is of: the input, repaired or refined, with what the file says of it. Pieces of a face have
// its label; vertices that were added come last, and the file says nothing of them.
LabelledSurface surface_of(const InputSurface& input, const Meshing& made) {
  const Surface& given = input.surface();
  const RefinedSurface& refined = made.refined;
  if (refined.subdivided.empty()) return {{made.mesh.V.topRows(given.V.rows()), given.F}, input.attributes};
  std::vector<Index> old_vertex(static_cast<std::size_t>(refined.surface.V.rows()), -1);
  std::iota(old_vertex.begin(), old_vertex.begin() + given.V.rows(), 0);
  return {refined.surface, carried(input.attributes, old_vertex, refined.face)};
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

// A number for each vertex of the file, as one for each vertex of the cleaned surface.
Result<std::vector<double>> sizes_of(const InputSurface& input, const std::string& file) {
  Result<std::vector<double>> given = read_sizes(file);
  if (!given || input.cleanup.vertex_of.empty()) return given;
  if (std::ssize(given.value()) != input.given_vertices)
    return Error{ErrorCode::usage, file + " has " + std::to_string(given.value().size()) +
                                       " sizes for the file's " + std::to_string(input.given_vertices) +
                                       " vertices; write one a vertex."};
  std::vector<double> sizes;
  for (const Index v : input.cleanup.vertex_of) sizes.push_back(given.value()[v]);
  return sizes;
}

// Reads, meshes and writes. What there is to tell is in the report, whatever happens.
Result<Meshing> make_mesh(const MeshCommand& command, TetFormat format, const RunContext& context,
                          Terminal& terminal, Watchdog& watchdog, Report& report) {
  context.report("read", 0);
  StageRecord read, labelled, written;
  const Result<InputSurface> loaded =
      timed("read", read, [&] { return load(command.input, command.clean, context, terminal); });
  report.stages = {read};
  if (!loaded) return loaded.error();
  const InputSurface& input = loaded.value();
  if (input.cleanup.problem) {
    tell(input, report);
    return *input.cleanup.problem;
  }
  MeshingOptions options = meshing_options(command);
  if (!command.sizes.file.empty()) {
    Result<std::vector<double>> sizes = sizes_of(input, command.sizes.file);
    if (!sizes) {
      tell(input, report);
      return sizes.error();
    }
    options.sizes.at_vertex = std::move(sizes).value();
  }
  Result<Meshing> made = tetrahedralize(input.surface(), options, context, &report);
  report.stages.insert(report.stages.begin(), read);
  tell(input, report);
  if (!made) return input.in_file(made.error());
  if (interrupt_flag()) return Error{ErrorCode::interrupted, "Interrupted; nothing was written."};
  context.report("label", 0);
  const LabelledSurface of = surface_of(input, made.value());
  MeshAttributeOptions wanted;
  wanted.layers = keeps_layers(format);
  if (report.status != RunStatus::repaired) wanted.winding_max = report.input.winding_max;
  const Result<MeshAttributes> attributes = timed("label", labelled, [&] {
    return mesh_attributes(of.surface, of.attributes, made.value().mesh, wanted, context);
  });
  report.stages.push_back(labelled);
  if (!attributes) return attributes.error();
  context.report("write", 0);
  const auto write = [&]() -> Status {
    if (!command.save_surface.empty())
      if (Status s =
              write_surface(command.save_surface, of.surface, surface_format_of(command.save_surface).value(),
                            context, &of.attributes.faces);
          !s)
        return s;
    return write_tets(command.output, made.value().mesh, attributes.value(), {format, command.order},
                      watchdog.writing(context));
  };
  if (Status s = timed("write", written, write); !s) return s.error();
  report.stages.push_back(written);
  return made;
}

// No file is to be written over another one.
Status check_names(const MeshCommand& command, const std::vector<std::string>& outputs) {
  if (!command.save_surface.empty())
    if (const auto named = surface_format_of(command.save_surface); !named) return named.error();
  if (same_file(command.input, command.report))
    return Error{ErrorCode::usage, "The report would overwrite the input; choose another name."};
  for (const std::string& output : outputs) {
    if (same_file(command.input, output))
      return Error{ErrorCode::usage, "The output would overwrite the input; choose another name."};
    if (same_file(output, command.report))
      return Error{ErrorCode::usage,
                   "The output and the report have the same name; choose another for one of them."};
  }
  std::vector<std::string> named = {command.input, command.report};
  named.insert(named.end(), outputs.begin(), outputs.end());
  for (const std::string* saved :
       {&command.save_surface, &command.clean.save_map, &command.clean.save_cleaned}) {
    for (const std::string& other : named)
      if (same_file(*saved, other))
        return Error{ErrorCode::usage, "Two files that are read or written are both called " + *saved +
                                           "; choose another name for one of them."};
    named.push_back(*saved);
  }
  return success();
}

// Pieces of a preset go with that one only.
Status check_pieces(const MeshCommand& c) {
  if (c.preset == "flow" && c.forward.empty() && c.reverse.empty() &&
      (c.map.empty() || c.map == "patch" || c.map == "pull"))
    return success();
  if (c.preset == "paper")
    return c.map != "patch" ? success()
                            : Error{ErrorCode::usage,
                                    "--map patch is a piece of --preset flow; of --preset paper it may be "
                                    "lim, arap or pull."};
  if (c.forward.empty() && c.reverse.empty() && c.map.empty()) return success();
  return Error{ErrorCode::usage,
               "--forward, --reverse and --map choose pieces of --preset paper, and --map patch or "
               "pull of --preset flow; give that preset, too."};
}

}  // namespace

int run(const MeshCommand& command, const CommonOptions& common, Terminal& terminal) {
  if (Status s = check_pieces(command); !s) return fail(terminal, s.error());
  if ((command.allow_branches || command.allow_flips) && command.preset != "paper")
    return fail(terminal,
                {ErrorCode::usage,
                 "--allow-branches and --allow-flips are about what --preset paper makes; give that, "
                 "too."});
  const Result<TetFormat> format = output_format(command.output, command.format, terminal);
  if (!format) return fail(terminal, format.error());
  const std::vector<std::string> outputs = tet_files(command.output, format.value());
  if (Status s = check_names(command, outputs); !s) return fail(terminal, s.error());
  std::vector<OutputProbe> output_probes(outputs.size());
  OutputProbe report_probe, surface_probe;
  if (!command.save_surface.empty())
    if (Status s = surface_probe.open(command.save_surface); !s) return fail(terminal, s.error());
  for (std::size_t i = 0; i < outputs.size(); ++i)
    if (Status s = output_probes[i].open(outputs[i]); !s) return fail(terminal, s.error());
  if (!command.report.empty())
    if (Status s = report_probe.open(command.report); !s) return fail(terminal, s.error());

  StageTrail trail;
  const RunContext context = trail.follow(common.context(terminal));
  const std::vector<Figure> options = options_of(command, common, format.value());
  const auto seconds = [&] {
    return std::chrono::duration<double>(RunContext::Clock::now() - common.start).count();
  };
  Watchdog watchdog(context, common.start, [&](const Error& error) {
    terminal.last_words(with_hint(error));
    if (error.code == ErrorCode::interrupted || command.report.empty()) return;
    Report late;  // what the stages have found is theirs
    late.options = options;
    late.stages = trail.records();
    late.status = status_of(error.code);
    late.message = with_hint(error);
    late.seconds = seconds();
    (void)write_report(command.report, late).ok();
  });

  Report report;
  Result<Meshing> made =
      caught([&] { return make_mesh(command, format.value(), context, terminal, watchdog, report); });
  if (!made) made = explained(made.error());
  if (!made) watchdog.settle(made.error().code);
  report.options = options;
  report.seconds = seconds();
  if (!made) report.status = status_of(made.error().code);
  report.message =
      made ? what_was_made(command, made.value(), report) + what_reads_faster(made.value(), format.value())
           : with_hint(made.error());
  if (!made) report.message += what_may_help(command, made.error());
  terminal.clear();
  if (report.status != RunStatus::interrupted) {
    if (Status s = write_report(command.report, report); !s) {
      if (made) return fail(terminal, s.error());
      terminal.error(s.error().message);
    }
  }
  if (!made) {
    terminal.error(report.message);
    return exit_code(made.error().code);
  }
  if (report.status == RunStatus::flipped) {
    terminal.error(report.message);
    return static_cast<int>(ErrorCode::unsolved);
  }
  terminal.say(report.message);
  return 0;
}

}  // namespace overtet
