// The extension module of the Python package: the library's replica, transfer, mesher and client,
// which the classes in dynmesh/*.py wrap.
#include <pybind11/pybind11.h>

#include <exception>

#include "client/python/module/bind.h"
#include "client/python/module/status.h"
#include "dynmesh/version.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::python {
namespace {

namespace py = pybind11;

// The index i of the field "edits[i]".
py::object EditOf(const std::string& field) {
  const std::size_t open = field.find("edits[");
  if (open == std::string::npos) return py::none();
  return py::int_(std::strtoull(field.c_str() + open + 6, nullptr, 10));
}

void Raise(const absl::Status& status) {
  py::list features;
  py::object edit = py::none(), retry_after = py::none();
  std::string reason, field;
  if (const auto error = codec::GetServiceError(status)) {
    reason = error->reason, field = error->field;
    for (const FeatureId id : error->Features()) features.append(id);
    edit = EditOf(field);
    if (error->retry_after) retry_after = py::float_(absl::ToDoubleSeconds(*error->retry_after));
  }
  const py::object error =
      py::module_::import("dynmesh.errors")
          .attr("make")(absl::StatusCodeToString(status.code()), std::string(status.message()),
                        reason, features, edit, field, retry_after);
  PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
}

}  // namespace
}  // namespace dynmesh::python

PYBIND11_MODULE(_core, module) {
  namespace py = pybind11;
  module.doc() = "The compiled part of dynmesh. Use the package's own names.";
  module.attr("version") = dynmesh::LinkedVersion();
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const dynmesh::python::StatusError& error) {
      dynmesh::python::Raise(error.status());
    }
  });
  dynmesh::python::BindEdits(module);
  dynmesh::python::BindMesh(module);
  dynmesh::python::BindPart(module);
  dynmesh::python::BindTransfer(module);
  dynmesh::python::BindClient(module);
  dynmesh::python::BindFiles(module);
}
