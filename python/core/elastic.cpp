#include "python/core/elastic.h"

#include <pybind11/stl.h>

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "overtet/elastic.h"
#include "python/core/arrays.h"
#include "python/core/calls.h"
#include "python/core/functions.h"
#include "python/core/records.h"

namespace overtet::python {

namespace {

using namespace py::literals;

std::vector<ElasticCondition> conditions_of(const py::handle& given, PythonFunctions& functions) {
  std::vector<ElasticCondition> out;
  for (const py::handle& item : given.cast<py::list>()) {
    const auto pair = py::reinterpret_borrow<py::tuple>(item);
    ElasticCondition c;
    put_place(pair[0], c.label, c.vertices);
    c.function = functions.take_vector(pair[1]);
    out.push_back(std::move(c));
  }
  return out;
}

VertexMatrix rows_of(const py::handle& given) {
  return given.is_none() ? VertexMatrix(0, 3) : matrix_of<VertexMatrix>(given.cast<py::array>());
}

ElasticOptions options_of(const py::dict& given, PythonFunctions& functions) {
  ElasticOptions o;
  const auto material = given["material"].cast<std::string>();
  o.material = material == "st-venant-kirchhoff" ? ElasticMaterial::st_venant_kirchhoff
               : material == "corotated"         ? ElasticMaterial::corotated
                                                 : ElasticMaterial::neo_hookean;
  o.young = given["young"].cast<double>();
  o.poisson = given["poisson"].cast<double>();
  o.density = given["density"].cast<double>();
  const auto gravity = given["gravity"].cast<std::array<double, 3>>();
  o.gravity = Eigen::Vector3d(gravity[0], gravity[1], gravity[2]);
  const auto damping = given["damping"].cast<std::array<double, 2>>();
  o.mass_damping = damping[0], o.stiffness_damping = damping[1];
  o.held = conditions_of(given["held"], functions);
  o.tractions = conditions_of(given["tractions"], functions);
  o.forces = conditions_of(given["forces"], functions);
  o.rest = rows_of(given["rest"]);
  o.velocities = rows_of(given["velocities"]);
  o.dynamic = given["dynamic"].cast<bool>();
  o.integrator = given["integrator"].cast<std::string>() == "bdf2" ? ElasticIntegrator::bdf2
                                                                   : ElasticIntegrator::implicit_euler;
  if (!given["method"].is_none())
    o.method =
        given["method"].cast<std::string>() == "newton" ? ElasticMethod::newton : ElasticMethod::quasi_newton;
  o.time_step = given["step"].cast<double>();
  o.frames = given["frames"].cast<int>();
  o.tolerance = given["tolerance"].cast<double>();
  o.most_iterations = given["iterations"].cast<int>();
  return o;
}

// A body with the functions that move it.
class Body {
 public:
  Body(const py::dict& mesh, const py::dict& options, const py::dict& run) {
    const LabelledTetMesh tets = labelled_tets_of(mesh);
    const ElasticOptions o = options_of(options, functions_);
    body_ = std::make_unique<Elastic>(
        value_of(call(run, [&](const RunContext& context) { return Elastic::prepare(tets, o, context); })));
  }

  py::dict step(const py::dict& run) {
    Result<ElasticStep> done = call(run, [&](const RunContext& context) { return body_->step(context); });
    functions_.raise_what_was_raised();
    const ElasticStep s = value_of(std::move(done));
    return py::dict("time"_a = s.time, "parts"_a = s.parts, "iterations"_a = s.iterations,
                    "line_search_steps"_a = s.line_search_steps, "factorisations"_a = s.factorisations,
                    "elastic_energy"_a = s.elastic_energy, "kinetic_energy"_a = s.kinetic_energy,
                    "residual"_a = s.residual, "converged"_a = s.converged, "least_ratio"_a = s.least_ratio,
                    "seconds"_a = s.seconds);
  }

  void move_held(const py::handle& vertices, const py::handle& places) {
    if (Status s = body_->move_held(vector_of<Index>(vertices), rows_of(places)); !s) raise(s.error());
  }

  py::array places() const { return array_of(VertexMatrix(body_->places())); }
  py::array velocities() const { return array_of(VertexMatrix(body_->velocities())); }
  double time() const { return body_->time(); }
  py::array von_mises() const { return array_of_values(body_->von_mises()); }
  py::array von_mises_at_vertices() const { return array_of_values(body_->von_mises_at_vertices()); }

 private:
  PythonFunctions functions_;
  std::unique_ptr<Elastic> body_;
};

}  // namespace

void add_elastic(py::module_& module) {
  py::class_<Body, std::shared_ptr<Body>>(module, "Elastic")
      .def(py::init<const py::dict&, const py::dict&, const py::dict&>())
      .def("step", &Body::step)
      .def("move_held", &Body::move_held)
      .def("places", &Body::places)
      .def("velocities", &Body::velocities)
      .def("time", &Body::time)
      .def("von_mises", &Body::von_mises)
      .def("von_mises_at_vertices", &Body::von_mises_at_vertices);
}

}  // namespace overtet::python
