// The extension module `_service`: meshes of a server, through the C++ client. Its batches, diffs
// and snapshots are of the types of `_core`, so that one is imported before.
#include <pybind11/pybind11.h>

#include <cstdlib>
#include <string>

#include "client/python/module/bind.h"
#include "client/python/module/status.h"
#include "dynmesh/codec/service_error.h"

namespace dynmesh::python {
namespace {

// The index i of the field "edits[i]".
std::optional<std::size_t> EditOf(const std::string& field) {
  const std::size_t open = field.find("edits[");
  if (open == std::string::npos) return std::nullopt;
  return std::strtoull(field.c_str() + open + 6, nullptr, 10);
}

ErrorFields FieldsOf(const absl::Status& status) {
  const auto error = codec::GetServiceError(status);
  if (!error) return {};
  ErrorFields fields;
  fields.reason = error->reason, fields.field = error->field;
  fields.features = error->Features(), fields.edit = EditOf(error->field);
  if (error->retry_after) fields.retry_after = absl::ToDoubleSeconds(*error->retry_after);
  return fields;
}

}  // namespace
}  // namespace dynmesh::python

PYBIND11_MODULE(_service, module) {
  pybind11::module_::import("dynmesh._core");
  module.doc() = "The compiled client of dynmesh. Use the package's own names.";
  dynmesh::python::RaiseStatuses<dynmesh::python::FieldsOf>();
  dynmesh::python::BindClient(module);
}
