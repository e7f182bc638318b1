// numpy arrays over columns of a mesh.
#ifndef DYNMESH_CLIENT_PYTHON_MODULE_ARRAYS_H_
#define DYNMESH_CLIENT_PYTHON_MODULE_ARRAYS_H_

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "client/python/module/held_column.h"
#include "core/base/mutex.h"

namespace dynmesh::python {

namespace py = pybind11;

template <class T>
using InArray = py::array_t<T, py::array::c_style | py::array::forcecast>;

// Holds a mutex. The GIL is given up if that has to wait, so the holder of a mutex may wait for the
// GIL. The holder makes no Python objects: these could run a finalizer that needs the mutex.
class ABSL_SCOPED_LOCKABLE PatientLock {
 public:
  explicit PatientLock(Mutex& mutex)
      ABSL_EXCLUSIVE_LOCK_FUNCTION(mutex) ABSL_NO_THREAD_SAFETY_ANALYSIS : mutex_(mutex) {
    if (mutex_.TryLock()) return;
    py::gil_scoped_release release;
    mutex_.Lock();
  }
  PatientLock(const PatientLock&) = delete;
  PatientLock& operator=(const PatientLock&) = delete;
  ~PatientLock() ABSL_UNLOCK_FUNCTION() { mutex_.Unlock(); }

 private:
  Mutex& mutex_;
};

// A column as a read-only array that never changes: rows of `width` entries, one-dimensional if
// `width` is 0.
template <class T>
py::array View(HeldColumn<T> column, std::size_t width = 0) {
  const auto size = static_cast<py::ssize_t>(column.size());
  std::vector<py::ssize_t> shape = {size};
  if (width > 0) shape = {size / static_cast<py::ssize_t>(width), static_cast<py::ssize_t>(width)};
  if (size == 0) return py::array_t<T>(shape);
  auto* const held = new HeldColumn<T>(std::move(column));
  const py::capsule owner(held, [](void* p) { delete static_cast<HeldColumn<T>*>(p); });
  py::array_t<T> array(shape, held->data(), owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
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
