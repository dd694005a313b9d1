// What `overtet` computes on meshes: fields, distances.
#pragma once

#include <pybind11/pybind11.h>

namespace overtet::python {

namespace py = pybind11;

void add_solvers(py::module_& module);

}  // namespace overtet::python
