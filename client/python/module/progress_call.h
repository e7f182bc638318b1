// A Python callback for the progress of a long call, which runs without the GIL.
#ifndef DYNMESH_CLIENT_PYTHON_MODULE_PROGRESS_CALL_H_
#define DYNMESH_CLIENT_PYTHON_MODULE_PROGRESS_CALL_H_

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

namespace dynmesh::python {

// An exception of the callback, or Ctrl-C, cancels the call, and is raised after the call has
// failed.
class ProgressCall {
 public:
  // `callback` may be None.
  explicit ProgressCall(const pybind11::object& callback) : callback_(callback) {}

  void operator()(const char* stage, std::uint64_t done, std::uint64_t total) {
    pybind11::gil_scoped_acquire acquire;
    try {
      if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
      if (!callback_.is_none()) callback_(stage, done, total);
    } catch (pybind11::error_already_set& error) {
      if (!raised_) raised_ = std::make_unique<pybind11::error_already_set>(std::move(error));
      cancelled_ = true;
    }
  }

  const std::atomic<bool>* cancelled() const { return &cancelled_; }

  // To be called after the call, with the GIL.
  void RaiseIf(bool failed) {
    if (raised_ && failed) throw std::move(*raised_);
  }

 private:
  const pybind11::object& callback_;
  std::atomic<bool> cancelled_ = false;
  std::unique_ptr<pybind11::error_already_set> raised_;
};

}  // namespace dynmesh::python

#endif  // DYNMESH_CLIENT_PYTHON_MODULE_PROGRESS_CALL_H_
