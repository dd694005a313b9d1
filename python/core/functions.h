// Python's functions of a place, which the library calls from its threads.
#pragma once

#include <pybind11/pybind11.h>

#include <exception>
#include <optional>
#include <utility>
#include <vector>

#include "overtet/elastic.h"
#include "overtet/solve.h"
#include "overtet/types.h"

namespace overtet::python {

namespace py = pybind11;

// What the first of them raises is kept, and raised when the library has returned. It must outlive what it
// gives, in the place where it was.
class PythonFunctions {
 public:
  PythonFunctions() = default;
  PythonFunctions(const PythonFunctions&) = delete;
  PythonFunctions& operator=(const PythonFunctions&) = delete;

  // given: a number, or a function of x, y and z.
  ScalarFunction take(const py::object& given);
  // given: None (no function), three numbers, or a function of x, y, z and t that gives three.
  VectorFunction take_vector(const py::object& given);

  void raise_what_was_raised() {
    if (raised_) std::rethrow_exception(std::exchange(raised_, nullptr));
  }

 private:
  std::vector<py::object> kept_;  // while the library has their pointers
  std::exception_ptr raised_;     // with the GIL held
};

// where: None (all), a label, or an array of vertices.
void put_place(const py::handle& where, std::optional<Index>& label, std::vector<Index>& vertices);

}  // namespace overtet::python
