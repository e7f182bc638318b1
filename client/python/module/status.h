// Converts statuses to Python exceptions, which dynmesh.errors makes.
//
// What a status has beside code and message is known to the modules: of the service, more.
#ifndef DYNMESH_CLIENT_PYTHON_MODULE_STATUS_H_
#define DYNMESH_CLIENT_PYTHON_MODULE_STATUS_H_

#include <pybind11/pybind11.h>

#include <cstddef>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/feature.h"

namespace dynmesh::python {

// Thrown inside this module only; callers get an exception of dynmesh.errors.
class StatusError : public std::exception {
 public:
  explicit StatusError(absl::Status status)
      : status_(std::move(status)), text_(status_.ToString()) {}
  const absl::Status& status() const { return status_; }
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  absl::Status status_;
  std::string text_;
};

inline void Check(const absl::Status& status) {
  if (!status.ok()) throw StatusError(status);
}
template <class T>
T Value(absl::StatusOr<T> result) {
  if (!result.ok()) throw StatusError(result.status());
  return *std::move(result);
}

// Of an exception; members as those of DynmeshError.
struct ErrorFields {
  std::string reason, field;
  std::vector<FeatureId> features;
  std::optional<std::size_t> edit;
  std::optional<double> retry_after;  // in seconds
};

// Sets Python's exception. Needs the GIL.
inline void Raise(const absl::Status& status, const ErrorFields& fields) {
  namespace py = pybind11;
  py::list features;
  for (const FeatureId id : fields.features) features.append(id);
  const auto or_none = [](const auto& value) -> py::object {
    return value ? py::cast(*value) : py::none();
  };
  const py::object error =
      py::module_::import("dynmesh.errors")
          .attr("make")(absl::StatusCodeToString(status.code()), std::string(status.message()),
                        fields.reason, features, or_none(fields.edit), fields.field,
                        or_none(fields.retry_after));
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
}

// Has exceptions of this module raised as `fields_of` describes their statuses.
template <ErrorFields fields_of(const absl::Status&)>
void RaiseStatuses() {
  pybind11::register_local_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const StatusError& error) {
      Raise(error.status(), fields_of(error.status()));
    }
  });
}

}  // namespace dynmesh::python

#endif  // DYNMESH_CLIENT_PYTHON_MODULE_STATUS_H_
