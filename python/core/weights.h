// Skinning weights.
#pragma once

#include <pybind11/pybind11.h>

namespace overtet::python {

namespace py = pybind11;

void add_weights(py::module_& module);

}  // namespace overtet::python
