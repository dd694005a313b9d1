#include <algorithm>
#include <cstdio>
#include <utility>

#include "overtet/io.h"
#include "overtet/solve.h"
#include "src/cli/expression.h"
#include "src/cli/places.h"
#include "src/cli/solve_kinds.h"

namespace overtet {

namespace {

// What is written, and what is said of it.
struct Solution {
  std::string name;  // of the data
  Eigen::VectorXd values;
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();
};

Result<Solution> field_of(const SolveCommand& c, const LabelledTetMesh& mesh, const RunContext& context) {
  FieldOptions o;
  o.equation = c.kind == "poisson"      ? FieldEquation::poisson
               : c.kind == "biharmonic" ? FieldEquation::biharmonic
                                        : FieldEquation::laplace;
  o.order = c.field.order;
  o.solver = c.field.solver == "direct"      ? LinearSolver::direct
             : c.field.solver == "iterative" ? LinearSolver::iterative
                                             : LinearSolver::automatic;
  Result<std::vector<BoundaryValue>> values = conditions_in(c.field.values, mesh),
                                     fluxes = conditions_in(c.field.fluxes, mesh);
  if (!values) return values.error();
  if (!fluxes) return fluxes.error();
  o.values = std::move(values).value();
  o.fluxes = std::move(fluxes).value();
  if (!c.field.source.empty()) {
    Result<ScalarFunction> source = function_of(c.field.source);
    if (!source) return source.error();
    o.source = std::move(source).value();
  }
  Result<Field> solved = solve_field(mesh, o, context);
  if (!solved) return solved.error();
  Field& f = solved.value();
  return Solution{"u",
                  std::move(f.values),
                  {{"energy", f.energy},
                   {"solver", f.solver == LinearSolver::iterative ? "iterative" : "direct"},
                   {"iterations", f.iterations},
                   {"residual", f.residual},
                   {"factor_entries", f.factor_entries},
                   {"seconds_assembly", f.seconds_assembly},
                   {"seconds_factor", f.seconds_factor},
                   {"seconds_solve", f.seconds_solve}}};
}

Result<Solution> distances_of(const SolveCommand& c, const LabelledTetMesh& mesh, const RunContext& context) {
  const Result<std::vector<Index>> sources = vertices_of(c.distances.from, mesh);
  if (!sources) return sources.error();
  DistanceOptions options;
  options.smoothing = c.distances.smoothing;
  const Result<Distances> prepared = Distances::prepare(mesh.mesh, options, context);
  if (!prepared) return prepared.error();
  Result<Eigen::VectorXd> found = prepared.value().from(sources.value(), context);
  if (!found) return found.error();
  return Solution{"distance", std::move(found).value()};
}

using Solver = Result<Solution>(const SolveCommand&, const LabelledTetMesh&, const RunContext&);

Result<SolveSummary> solve_and_write(Solver solver, const SolveCommand& c, const RunContext& context,
                                     const RunContext& writing) {
  const Result<TetFormat> format = tet_format_of(c.output);
  if (!format) return format.error();
  if (format.value() != TetFormat::vtu && format.value() != TetFormat::vtk)
    return Error{ErrorCode::usage,
                 "Fields are written as .vtu or .vtk; the other formats have no place for them."};
  context.report("read", 0);
  Result<LabelledTetMesh> read = read_labelled_tets(c.input, context);
  if (!read) return read.error();
  LabelledTetMesh& mesh = read.value();
  context.report("solve", 0);
  Result<Solution> solved = solver(c, mesh, context);
  if (!solved) return solved.error();
  const Eigen::VectorXd& u = solved.value().values;
  put_vertex_data(mesh.attributes, solved.value().name, 1,
                  std::vector<double>(u.data(), u.data() + u.size()));
  TetWriteOptions options;
  options.format = format.value();
  options.order = c.field.order;
  if (Status s = write_tets(c.output, mesh.mesh, mesh.attributes, options, writing); !s) return s.error();
  SolveSummary out;
  out.figures = {{"nodes", u.size()}, {"least", u.minCoeff()}, {"most", u.maxCoeff()}};
  out.figures.update(solved.value().figures);
  char text[120];
  std::snprintf(text, sizeof text, "%s at %lld nodes, from %.6g to %.6g", solved.value().name.c_str(),
                static_cast<long long>(u.size()), u.minCoeff(), u.maxCoeff());
  out.sentence = text;
  return out;
}

}  // namespace

void put_vertex_data(MeshAttributes& attributes, const std::string& name, int width,
                     std::vector<double> values) {
  std::erase_if(attributes.vertex_data, [&](const Attribute& a) { return a.name == name; });
  attributes.vertex_data.push_back({name, NumberType::float64, width, std::move(values)});
}

Result<SolveSummary> solve_for_field(const SolveCommand& command, const RunContext& context,
                                     const RunContext& writing) {
  return solve_and_write(field_of, command, context, writing);
}

Result<SolveSummary> solve_for_distances(const SolveCommand& command, const RunContext& context,
                                         const RunContext& writing) {
  return solve_and_write(distances_of, command, context, writing);
}

}  // namespace overtet
