#include "src/cli/solve_options.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include "src/cli/arguments.h"

namespace overtet {

namespace {

// A kind of problem: who solves it, and the group of its options in the help.
struct Kind {
  const char* name;
  const char* group;
  SolveFunction* solver;
};
const char* const of_fields = "Of laplace, poisson and biharmonic";
const char* const of_distances = "Of geodesic";
const char* const of_skinning = "Of weights and skin";
const char* const of_elastic = "Of elastic";
const Kind kKinds[] = {
    {"laplace", of_fields, solve_for_field},     {"poisson", of_fields, solve_for_field},
    {"biharmonic", of_fields, solve_for_field},  {"geodesic", of_distances, solve_for_distances},
    {"weights", of_skinning, solve_for_weights}, {"skin", of_skinning, solve_for_skin},
    {"elastic", of_elastic, solve_for_elastic}};

const Kind& kind_named(const std::string& name) {
  return *std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return k.name == name; });
}

void add_fields(CLI::App& command, FieldWords& field) {
  command
      .add_option("--value", field.values,
                  "WHERE=FORMULA: the field there; may be repeated, and later ones count where they meet")
      ->group(of_fields);
  command
      .add_option(
          "--flux", field.fluxes,
          "WHERE=FORMULA: the derivative along the outer normal (0 elsewhere); may be repeated, and adds up")
      ->group(of_fields);
  command.add_option("--source", field.source, "f, a formula (default: 0)")->group(of_fields);
  command.add_option("--order", field.order, "Of the elements: 1 or, with nodes in the middle of edges, 2")
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str()
      ->group(of_fields);
  command
      .add_option("--solver", field.solver,
                  "automatic, direct (a Cholesky factor) or iterative (conjugate gradients with multigrid)")
      ->check(CLI::IsMember({"automatic", "direct", "iterative"}))
      ->capture_default_str()
      ->group(of_fields);
}

void add_distances(CLI::App& command, DistanceWords& distances) {
  command.add_option("--from", distances.from, "WHERE distances are measured from (needed); may be repeated")
      ->group(of_distances);
  command
      .add_option("--smoothing", distances.smoothing, "The heat's time, in squares of the mean edge length")
      ->check(between(0.5, 1e6))
      ->capture_default_str()
      ->group(of_distances);
}

void add_skinning(CLI::App& command, SkinningWords& skinning) {
  command
      .add_option("--handles", skinning.handles,
                  "File of the points and bones (needed): JSON (docs/handles.md) or TGF (.tgf)")
      ->group(of_skinning);
  command
      .add_flag("--cut-bones", skinning.cut_bones,
                "Of weights: bones that leave the solid are cut off there (default: an error)")
      ->group(of_skinning);
  command
      .add_option("--weights", skinning.weights,
                  "Of skin (needed): the weights, a .vtu or .csv file from solve weights")
      ->group(of_skinning);
  command.add_option("--pose", skinning.pose, "Of skin (needed): JSON, the motion of each handle that moves")
      ->group(of_skinning);
}

void check_skinning(const std::string& kind, const SkinningWords& words) {
  if (words.handles.empty()) throw CLI::ValidationError("Handles are needed: --handles FILE");
  if (kind == "weights") {
    if (!words.weights.empty()) throw CLI::ValidationError("--weights is no option of weights");
    if (!words.pose.empty()) throw CLI::ValidationError("--pose is no option of weights");
    return;
  }
  if (words.cut_bones) throw CLI::ValidationError("--cut-bones is no option of skin");
  if (words.weights.empty()) throw CLI::ValidationError("Weights are needed: --weights FILE");
  if (words.pose.empty()) throw CLI::ValidationError("A pose is needed: --pose FILE");
}

void add_elastic_loads(CLI::App& command, ElasticWords& elastic) {
  const auto add = [&](const char* name, auto& to, const char* what) {
    command.add_option(name, to, what)->group(of_elastic);
  };
  add("--fix", elastic.fixed, "WHERE nothing moves; may be repeated");
  add("--pull", elastic.pulled,
      "WHERE=FX;FY;FZ: the displacement there, three formulas; may be repeated, and counts more than --fix");
  add("--traction", elastic.tractions,
      "WHERE=FX;FY;FZ: the force per area there, on boundary triangles; may be repeated, and adds up");
  add("--force", elastic.forces,
      "vertices:N,N=FX;FY;FZ: the force at each of these vertices; may be repeated, and adds up");
  add("--gravity", elastic.gravity, "X,Y,Z: the acceleration (default: none)");
  add("--rest", elastic.rest, "The same tets with other vertices: the shape without stress (default: MESH)");
}

void add_elastic(CLI::App& command, ElasticWords& elastic) {
  const auto add = [&](const char* name, auto& to, const char* what) {
    return command.add_option(name, to, what)->capture_default_str()->group(of_elastic);
  };
  add("--material", elastic.material, "The law: neo-hookean, corotated or st-venant-kirchhoff")
      ->check(CLI::IsMember({"neo-hookean", "corotated", "st-venant-kirchhoff"}));
  add("--young", elastic.young, "Young's modulus")->check(more_than_zero());
  add("--poisson", elastic.poisson, "Poisson's ratio")->check(between(0, 0.499));
  add("--density", elastic.density, "Mass by volume at rest")->check(more_than_zero());
  add_elastic_loads(command, elastic);
  command.add_flag("--dynamic", elastic.dynamic, "Motion in time; without it equilibria are found")
      ->group(of_elastic);
  add("--frames", elastic.frames, "Steps in time; without --dynamic equilibria at times from 1/N to 1")
      ->check(CLI::PositiveNumber);
  add("--step", elastic.step, "The time from frame to frame")->check(more_than_zero());
  command.add_option("--damping", elastic.damping, "MASS,STIFFNESS: Rayleigh's factors (default: 0,0)")
      ->group(of_elastic);
  add("--integrator", elastic.integrator, "euler (implicit) or bdf2, which damps less")
      ->check(CLI::IsMember({"euler", "bdf2"}));
  command
      .add_option("--method", elastic.method,
                  "newton, or quasi-newton, which factors one matrix only: quick frames (default: newton)")
      ->check(CLI::IsMember({"newton", "quasi-newton"}))
      ->group(of_elastic);
  add("--tolerance", elastic.tolerance, "Of the forces left over, relative to those in the tets")
      ->check(between(1e-14, 0.5));
  add("--iterations", elastic.iterations, "The most a frame may have; motion goes on after them")
      ->check(CLI::PositiveNumber);
}

// What another kind has options for is refused.
void check_groups(const CLI::App& command, const SolveCommand& solve) {
  const Kind& kind = kind_named(solve.kind);
  for (const CLI::Option* option : command.get_options())
    for (const Kind& other : kKinds)
      if (option->count() > 0 && option->get_group() == other.group && option->get_group() != kind.group)
        throw CLI::ValidationError(option->get_name() + " is no option of " + solve.kind);
  if (std::string_view(kind.group) == of_distances && solve.distances.from.empty())
    throw CLI::ValidationError("Distances need a source: --from WHERE");
  if (std::string_view(kind.group) == of_skinning) check_skinning(solve.kind, solve.skinning);
  if (std::string_view(kind.group) == of_elastic && !solve.elastic.dynamic) {
    for (const char* name : {"--step", "--damping", "--integrator"})
      if (command.count(name) > 0)
        throw CLI::ValidationError(std::string(name) + " is for motion: --dynamic");
  }
}

}  // namespace

CLI::App* add_solve(CLI::App& app, SolveCommand& solve) {
  CLI::App* command = app.add_subcommand(
      "solve",
      "Compute a field or an elastic body on a tet mesh: what its layers have in one place is kept apart");
  std::vector<std::string> kinds;
  for (const Kind& kind : kKinds) kinds.emplace_back(kind.name);
  command
      ->add_option(
          "KIND", solve.kind,
          "laplace, poisson (-Laplace(u) = f), biharmonic (Laplace(Laplace(u)) = f), geodesic "
          "(distances inside), weights (for skinning, of handles), skin (the mesh in a pose), or elastic "
          "(an elastic body; its layers do not collide)")
      ->required()
      ->check(CLI::IsMember(kinds));
  command->add_option("MESH", solve.input, "Tet mesh: .mesh, .msh, .vtu, .node, .inp or .vtk")->required();
  command
      ->add_option("--output,-o", solve.output,
                   "The mesh with the field: .vtu or .vtk; of weights also .glb (the boundary with a "
                   "skeleton) or .csv; of elastic bodies also .pvd, a .vtu a frame beside it")
      ->required();
  command->add_flag("--json", solve.json, "Print JSON");
  add_fields(*command, solve.field);
  add_distances(*command, solve.distances);
  add_skinning(*command, solve.skinning);
  add_elastic(*command, solve.elastic);
  command->callback([command, &solve] { check_groups(*command, solve); });
  command->footer(
      "WHERE: all (of the boundary), label:NUMBER, label:NAME, vertices:N,N,... (counted from 0) or "
      "vertices:@FILE. FORMULA: of x, y and z "
      "(muParser), or @FILE; of elastic bodies also of the time t. Values must be given somewhere in every "
      "component. "
      "Elastic bodies: any units that go together. Overlapping layers do not collide; no tet is ever "
      "flipped.");
  return command;
}

SolveFunction* solver_of(const std::string& kind) { return kind_named(kind).solver; }

}  // namespace overtet
