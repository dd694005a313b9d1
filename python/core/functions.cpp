#include "python/core/functions.h"

#include <pybind11/stl.h>

#include <array>
#include <limits>

#include "python/core/arrays.h"

namespace overtet::python {

ScalarFunction PythonFunctions::take(const py::object& given) {
  if (!PyCallable_Check(given.ptr())) {
    const auto value = given.cast<double>();
    return [value](const Eigen::Vector3d&) { return value; };
  }
  kept_.push_back(given);
  return [this, function = given.ptr()](const Eigen::Vector3d& p) {
    const py::gil_scoped_acquire acquired;
    const double none = std::numeric_limits<double>::quiet_NaN();
    if (raised_) return none;
    try {
      return py::reinterpret_borrow<py::object>(function)(p[0], p[1], p[2]).cast<double>();
    } catch (...) {
      raised_ = std::current_exception();
      return none;
    }
  };
}

VectorFunction PythonFunctions::take_vector(const py::object& given) {
  using Three = std::array<double, 3>;
  if (given.is_none()) return {};
  const auto vector = [](const Three& v) { return Eigen::Vector3d(v[0], v[1], v[2]); };
  if (!PyCallable_Check(given.ptr())) {
    const Eigen::Vector3d value = vector(given.cast<Three>());
    return [value](const Eigen::Vector3d&, double) { return value; };
  }
  kept_.push_back(given);
  return [this, vector, function = given.ptr()](const Eigen::Vector3d& p, double t) -> Eigen::Vector3d {
    const py::gil_scoped_acquire acquired;
    const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
    if (raised_) return none;
    try {
      const py::object got = py::reinterpret_borrow<py::object>(function)(p[0], p[1], p[2], t);
      return vector(py::list(got).cast<Three>());
    } catch (...) {
      raised_ = std::current_exception();
      return none;
    }
  };
}

void put_place(const py::handle& where, std::optional<Index>& label, std::vector<Index>& vertices) {
  if (py::isinstance<py::int_>(where))
    label = where.cast<Index>();
  else if (!where.is_none())
    vertices = vector_of<Index>(where);
}

}  // namespace overtet::python
