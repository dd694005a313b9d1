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
constexpr const char* kFields = "Of laplace, poisson and biharmonic";
constexpr const char* kDistances = "Of geodesic";
const Kind kKinds[] = {{"laplace", kFields, solve_for_field},
                       {"poisson", kFields, solve_for_field},
                       {"biharmonic", kFields, solve_for_field},
                       {"geodesic", kDistances, solve_for_distances}};

const Kind& kind_named(const std::string& name) {
  return *std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return k.name == name; });
}

void add_fields(CLI::App& command, FieldWords& field) {
  command
      .add_option("--value", field.values,
                  "WHERE=FORMULA: the field there; may be repeated, and later ones count where they meet")
      ->group(kFields);
  command
      .add_option(
          "--flux", field.fluxes,
          "WHERE=FORMULA: the derivative along the outer normal (0 elsewhere); may be repeated, and adds up")
      ->group(kFields);
  command.add_option("--source", field.source, "f, a formula (default: 0)")->group(kFields);
  command.add_option("--order", field.order, "Of the elements: 1 or, with nodes in the middle of edges, 2")
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str()
      ->group(kFields);
  command
      .add_option("--solver", field.solver,
                  "automatic, direct (a Cholesky factor) or iterative (conjugate gradients with multigrid)")
      ->check(CLI::IsMember({"automatic", "direct", "iterative"}))
      ->capture_default_str()
      ->group(kFields);
}

void add_distances(CLI::App& command, DistanceWords& distances) {
  command.add_option("--from", distances.from, "WHERE distances are measured from (needed); may be repeated")
      ->group(kDistances);
  command
      .add_option("--smoothing", distances.smoothing, "The heat's time, in squares of the mean edge length")
      ->check(between(1e-6, 1e6))
      ->capture_default_str()
      ->group(kDistances);
}

// What another kind has options for is refused.
void check_groups(const CLI::App& command, const SolveCommand& solve) {
  const Kind& kind = kind_named(solve.kind);
  for (const CLI::Option* option : command.get_options())
    for (const Kind& other : kKinds)
      if (option->count() > 0 && option->get_group() == other.group && option->get_group() != kind.group)
        throw CLI::ValidationError(option->get_name() + " is no option of " + solve.kind);
  if (std::string_view(kind.group) == kDistances && solve.distances.from.empty())
    throw CLI::ValidationError("Distances need a source: --from WHERE");
}

}  // namespace

CLI::App* add_solve(CLI::App& app, SolveCommand& solve) {
  CLI::App* command = app.add_subcommand(
      "solve", "Compute a field on a tet mesh: what its layers have in one place is kept apart");
  std::vector<std::string> kinds;
  for (const Kind& kind : kKinds) kinds.emplace_back(kind.name);
  command
      ->add_option("KIND", solve.kind,
                   "laplace, poisson (-Laplace(u) = f), biharmonic (Laplace(Laplace(u)) = f), or geodesic "
                   "(distances inside)")
      ->required()
      ->check(CLI::IsMember(kinds));
  command->add_option("MESH", solve.input, "Tet mesh: .mesh, .msh, .vtu, .node, .inp or .vtk")->required();
  command->add_option("--output,-o", solve.output, "The mesh with the field: .vtu or .vtk")->required();
  command->add_flag("--json", solve.json, "Print JSON");
  add_fields(*command, solve.field);
  add_distances(*command, solve.distances);
  command->callback([command, &solve] { check_groups(*command, solve); });
  command->footer(
      "WHERE: all (of the boundary), label:NUMBER, label:NAME, vertices:N,N,... (counted from 0) or "
      "vertices:@FILE. FORMULA: of x, y and z "
      "(muParser), or @FILE. Values must be given somewhere in every component.");
  return command;
}

SolveFunction* solver_of(const std::string& kind) { return kind_named(kind).solver; }

}  // namespace overtet
