// Features from files.
#include "dynmesh/files.h"

#include <pybind11/stl.h>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/status.h"

namespace dynmesh::python {
namespace {

py::dict Read(const std::string& path, bool merge_coplanar, bool polygons, bool refine,
              bool keep_facets) {
  absl::StatusOr<FileInput> input = absl::UnknownError("");
  {
    py::gil_scoped_release release;
    input = ReadInput(path, InputChoices{merge_coplanar, polygons, refine, keep_facets});
  }
  const FileInput file = Value(std::move(input));
  py::list holes;
  for (const auto& [x, y, z] : file.holes) {
    holes.append(file.options.dimension == 2 ? py::make_tuple(x, y) : py::make_tuple(x, y, z));
  }
  py::dict result;
  result["options"] = OptionsDict(file.options);
  result["features"] = FeatureDicts(file.features, file.options.dimension);
  result["holes"] = holes;
  result["places"] = py::cast(file.places);
  result["warnings"] = py::cast(file.warnings);
  return result;
}

}  // namespace

void BindFiles(py::module_& module) {
  module.def("read_input", &Read, py::arg("path"), py::arg("merge_coplanar"), py::arg("polygons"),
             py::arg("refine"), py::arg("keep_facets"));
}

}  // namespace dynmesh::python
