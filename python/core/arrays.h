// Numpy arrays as the library's matrices, and back. In: one copy, from any memory order. Out: the array owns
// the library's memory.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "overtet/types.h"

namespace overtet::python {

namespace py = pybind11;

// The library's text need not be UTF-8. Messages are to be printed, names are to come back as they were.
py::str message_text(const std::string& text);
py::str name_text(const std::string& text);
std::string name_bytes(const py::handle& text);

// A number of `array` that is no 32-bit index: its row, and the number. The caller says what it is.
struct OutOfRange {
  std::int64_t row = 0;
  std::string number;
};

namespace detail {

template <class Scalar>
struct Strided {
  const char* data;
  py::ssize_t row, column;
  Scalar operator()(py::ssize_t i, py::ssize_t j) const {
    return *reinterpret_cast<const Scalar*>(data + i * row + j * column);
  }
};

template <class From, class To>
void copy(const py::array& array, To* to, py::ssize_t rows, py::ssize_t columns) {
  const Strided<From> from{static_cast<const char*>(array.data()), array.strides(0),
                           array.ndim() > 1 ? array.strides(1) : 0};
  for (py::ssize_t i = 0; i < rows; ++i)
    for (py::ssize_t j = 0; j < columns; ++j) {
      const From x = from(i, j);
      if constexpr (std::is_integral_v<To>)
        if (!std::in_range<To>(x)) throw OutOfRange{i, std::to_string(x)};
      *to++ = static_cast<To>(x);
    }
}

}  // namespace detail

// pre: two dimensions (or one, for `columns` 1), native byte order, aligned; doubles, floats or integers of
// 32 or 64 bits: overtet/_arrays.py sees to that. Throws OutOfRange.
template <class To>
void copy_array(const py::array& array, To* to, py::ssize_t columns) {
  const py::ssize_t rows = array.shape(0);
  const char kind = array.dtype().kind();
  const auto size = array.itemsize();
  if constexpr (std::is_floating_point_v<To>) {
    if (kind == 'f' && size == 8) return detail::copy<double>(array, to, rows, columns);
    if (kind == 'f' && size == 4) return detail::copy<float>(array, to, rows, columns);
  }
  if (kind == 'i' && size == 4) return detail::copy<std::int32_t>(array, to, rows, columns);
  if (kind == 'i' && size == 8) return detail::copy<std::int64_t>(array, to, rows, columns);
  if (kind == 'u' && size == 8) return detail::copy<std::uint64_t>(array, to, rows, columns);
  throw py::type_error("overtet._core: an array of a type that it does not know");
}

template <class Matrix>
Matrix matrix_of(const py::array& array) {
  constexpr int columns = Matrix::ColsAtCompileTime;
  if (array.ndim() != 2 || array.shape(1) != columns)
    throw py::value_error("overtet._core: an array of another shape");
  Matrix m(array.shape(0), columns);
  copy_array(array, m.data(), columns);
  return m;
}

template <class T>
std::vector<T> vector_of(const py::handle& given) {
  if (given.is_none()) return {};
  const auto array = py::reinterpret_borrow<py::array>(given);
  if (array.ndim() != 1) throw py::value_error("overtet._core: an array of another shape");
  std::vector<T> v(static_cast<std::size_t>(array.shape(0)));
  copy_array(array, v.data(), 1);
  return v;
}

// `owner` lives as long as the array; `data` is in it.
template <class Scalar, class Owner>
py::array owned(Owner owner, std::vector<py::ssize_t> shape) {
  auto* kept = new Owner(std::move(owner));
  const py::capsule capsule(kept, [](void* p) { delete static_cast<Owner*>(p); });
  return py::array_t<Scalar>(std::move(shape), reinterpret_cast<const Scalar*>(kept->data()), capsule);
}

template <class Scalar, int Columns>
py::array array_of(Eigen::Matrix<Scalar, Eigen::Dynamic, Columns, Eigen::RowMajor> m) {
  const py::ssize_t rows = m.rows();
  return owned<Scalar>(std::move(m), {rows, Columns});
}

inline py::array array_of_values(Eigen::VectorXd v) {
  const auto rows = static_cast<py::ssize_t>(v.size());
  return owned<double>(std::move(v), {rows});
}

template <class T>
py::array array_of(std::vector<T> v) {
  const auto rows = static_cast<py::ssize_t>(v.size());
  return owned<T>(std::move(v), {rows});
}

template <class T, std::size_t N>
py::array array_of(std::vector<std::array<T, N>> v) {
  const auto rows = static_cast<py::ssize_t>(v.size());
  return owned<T>(std::move(v), {rows, static_cast<py::ssize_t>(N)});
}

}  // namespace overtet::python
