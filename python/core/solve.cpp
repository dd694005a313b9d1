#include "python/core/solve.h"

#include <pybind11/stl.h>

#include <exception>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "overtet/solve.h"
#include "python/core/arrays.h"
#include "python/core/calls.h"
#include "python/core/functions.h"
#include "python/core/records.h"

namespace overtet::python {

namespace {

using namespace py::literals;

// given: (where, function); where: None (all), a label, or an array of vertices.
std::vector<BoundaryValue> values_of(const py::list& given, PythonFunctions& functions) {
  std::vector<BoundaryValue> out;
  for (const py::handle& item : given) {
    const auto pair = py::reinterpret_borrow<py::tuple>(item);
    BoundaryValue b;
    put_place(pair[0], b.label, b.vertices);
    b.function = functions.take(pair[1]);
    out.push_back(std::move(b));
  }
  return out;
}

py::dict solve_(const py::dict& mesh, const py::dict& options, const py::dict& run) {
  const LabelledTetMesh tets = labelled_tets_of(mesh);
  FieldOptions o;
  const auto equation = options["equation"].cast<std::string>();
  o.equation = equation == "poisson"      ? FieldEquation::poisson
               : equation == "biharmonic" ? FieldEquation::biharmonic
                                          : FieldEquation::laplace;
  o.order = options["order"].cast<int>();
  PythonFunctions functions;
  o.values = values_of(options["values"], functions);
  o.fluxes = values_of(options["fluxes"], functions);
  if (!options["source"].is_none()) o.source = functions.take(options["source"]);
  Result<Field> solved = call(run, [&](const RunContext& context) { return solve_field(tets, o, context); });
  functions.raise_what_was_raised();
  Field f = value_of(std::move(solved));
  return py::dict("nodes"_a = array_of(std::move(f.nodes)), "values"_a = array_of_values(std::move(f.values)),
                  "energy"_a = f.energy, "residual"_a = f.residual);
}

std::shared_ptr<Distances> prepare_distances(const py::handle& V, const py::handle& T, double smoothing,
                                             const py::dict& run) {
  const TetMesh mesh = tets_of(V, T);
  DistanceOptions options;
  options.smoothing = smoothing;
  return std::make_shared<Distances>(value_of(
      call(run, [&](const RunContext& context) { return Distances::prepare(mesh, options, context); })));
}

py::array distances_from(const Distances& distances, const py::handle& given, const py::dict& run) {
  const std::vector<Index> sources = vector_of<Index>(given);
  return array_of_values(
      value_of(call(run, [&](const RunContext& context) { return distances.from(sources, context); })));
}

}  // namespace

void add_solvers(py::module_& module) {
  module.def("solve", &solve_);
  py::class_<Distances, std::shared_ptr<Distances>>(module, "Distances")
      .def(py::init(&prepare_distances))
      .def("distances_from", &distances_from);
}

}  // namespace overtet::python
