// Elastic bodies.
#pragma once

#include <pybind11/pybind11.h>

namespace overtet::python {

void add_elastic(pybind11::module_& module);

}  // namespace overtet::python
