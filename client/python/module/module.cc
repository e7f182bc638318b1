// The extension module `_core`: the library's mesher, replica, parts, transfer and files, which the
// classes in dynmesh/*.py wrap. Nothing of it needs a network.
#include <pybind11/pybind11.h>

#include "client/python/module/bind.h"
#include "client/python/module/status.h"
#include "dynmesh/error.h"
#include "dynmesh/version.h"

namespace dynmesh::python {
namespace {

ErrorFields FieldsOf(const absl::Status& status) {
  const auto detail = GetErrorDetail(status);
  if (!detail) return {};
  ErrorFields fields;
  fields.reason = detail->reason, fields.features = detail->features, fields.edit = detail->edit;
  if (detail->edit) fields.field = "edits[" + std::to_string(*detail->edit) + "]";
  return fields;
}

}  // namespace
}  // namespace dynmesh::python

PYBIND11_MODULE(_core, module) {
  module.doc() = "The compiled part of dynmesh. Use the package's own names.";
  module.attr("version") = dynmesh::LinkedVersion();
  dynmesh::python::RaiseStatuses<dynmesh::python::FieldsOf>();
  dynmesh::python::BindEdits(module);
  dynmesh::python::BindMesh(module);
  dynmesh::python::BindPart(module);
  dynmesh::python::BindTransfer(module);
  dynmesh::python::BindFiles(module);
  dynmesh::python::BindColumns(module);
}
