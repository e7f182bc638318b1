// Converts statuses to Python exceptions, which dynmesh.errors makes.
#ifndef DYNMESH_CLIENT_PYTHON_MODULE_STATUS_H_
#define DYNMESH_CLIENT_PYTHON_MODULE_STATUS_H_

#include <exception>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

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

}  // namespace dynmesh::python

#endif  // DYNMESH_CLIENT_PYTHON_MODULE_STATUS_H_
