// numpy arrays over columns: views that keep the owner of the data alive.
#ifndef DYNMESH_CLIENT_PYTHON_MODULE_ARRAYS_H_
#define DYNMESH_CLIENT_PYTHON_MODULE_ARRAYS_H_

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "dynmesh/slot_mesh.h"

namespace dynmesh::python {

namespace py = pybind11;

template <class T>
using InArray = py::array_t<T, py::array::c_style | py::array::forcecast>;

// Rows of `width` entries, one-dimensional if `width` is 0. Read-only.
template <class T>
py::array View(std::shared_ptr<const T[]> block, std::size_t size, std::size_t width) {
  const T* const data = block.get();
  const py::capsule owner(new std::shared_ptr<const T[]>(std::move(block)), [](void* held) {
    delete static_cast<std::shared_ptr<const T[]>*>(held);
  });
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(size)};
  if (width > 0) shape = {static_cast<py::ssize_t>(size / width), static_cast<py::ssize_t>(width)};
  py::array_t<T> array(shape, data, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

template <class T>
py::array View(const SlotColumn<T>& column, std::size_t width = 0) {
  if (column.size() == 0) {
    std::vector<py::ssize_t> shape = {0};
    if (width > 0) shape.push_back(static_cast<py::ssize_t>(width));
    return py::array_t<T>(shape);
  }
  return View<T>(column.share(), column.size(), width);
}

// An array that takes over a vector's entries.
template <class T>
py::array Take(std::vector<T> values, std::size_t width = 0) {
  auto* const held = new std::vector<T>(std::move(values));
  const py::capsule owner(held, [](void* p) { delete static_cast<std::vector<T>*>(p); });
  std::vector<py::ssize_t> shape = {static_cast<py::ssize_t>(held->size())};
  if (width > 0) {
    shape = {static_cast<py::ssize_t>(held->size() / width), static_cast<py::ssize_t>(width)};
  }
  return py::array_t<T>(shape, held->data(), owner);
}

template <class T>
std::span<const T> SpanOf(const InArray<T>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

inline void Require(bool holds, const std::string& what) {
  if (!holds) throw py::value_error(what);
}

}  // namespace dynmesh::python

#endif  // DYNMESH_CLIENT_PYTHON_MODULE_ARRAYS_H_
