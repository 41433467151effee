/// Columns of numbers as arrays.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <vector>

namespace ssjs::bindings {

template <class Number>
[[nodiscard]] pybind11::array array_of(const std::vector<Number>& values) {
  return pybind11::array_t<Number>(static_cast<pybind11::ssize_t>(values.size()), values.data());
}

}  // namespace ssjs::bindings
