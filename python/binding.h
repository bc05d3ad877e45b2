// What pybind11 and nanobind spell differently, so that the module is written once. Debian has
// pybind11, whose modules are for the one Python that they are compiled for. nanobind, from PyPI,
// makes modules for the stable ABI, which are for every Python from 3.12 on
// (scripts/build_wheels.sh).
#pragma once
#ifdef Py_LIMITED_API
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>
#else
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#endif

#include <cstddef>
#include <exception>
#include <memory>
#include <utility>

#ifdef Py_LIMITED_API

namespace py = nanobind;
#define SKYWAVE_PYTHON_MODULE NB_MODULE
using PythonError = py::python_error;

// An argument that needs no conversion, if it is declared with noconvert().
template <class Number>
using Array = py::ndarray<const Number, py::c_contig, py::device::cpu>;

// What the module returns.
using FloatArray = py::ndarray<py::numpy, float>;

inline FloatArray NewFloatArray(std::size_t rank, const std::size_t* shape) {
  std::size_t size = 1;
  for (std::size_t axis = 0; axis < rank; ++axis) size *= shape[axis];
  auto numbers = std::make_unique<float[]>(size);
  const py::capsule owner(numbers.get(), [](void* p) noexcept { delete[] static_cast<float*>(p); });
  return {numbers.release(), rank, shape, owner};
}
inline float* DataOf(FloatArray& array) { return array.data(); }

template <class Function>
auto Constructor(Function function) {
  return py::new_(std::move(function));
}

template <class Object>
Object Steal(PyObject* object) {
  return py::steal<Object>(object);
}

inline py::module_ Import(const char* name) { return py::module_::import_(name); }

// Lets `translate` set Python's error for exceptions of C++ that it knows.
template <auto translate>
void RegisterTranslator() {
  py::register_exception_translator([](const std::exception_ptr& e, void*) { translate(e); });
  py::set_leak_warnings(false);  // Python does not free everything when it ends
}

#else

namespace py = pybind11;
#define SKYWAVE_PYTHON_MODULE PYBIND11_MODULE
using PythonError = py::error_already_set;

template <class Number>
using Array = py::array_t<Number, py::array::c_style>;

using FloatArray = py::array_t<float>;

inline FloatArray NewFloatArray(std::size_t rank, const std::size_t* shape) {
  return FloatArray(py::array::ShapeContainer(shape, shape + rank));
}
inline float* DataOf(FloatArray& array) { return array.mutable_data(); }

template <class Function>
auto Constructor(Function function) {
  return py::init(std::move(function));
}

template <class Object>
Object Steal(PyObject* object) {
  return py::reinterpret_steal<Object>(object);
}

inline py::module_ Import(const char* name) { return py::module_::import(name); }

template <auto translate>
void RegisterTranslator() {
  py::register_exception_translator([](std::exception_ptr e) { translate(e); });
}

#endif
