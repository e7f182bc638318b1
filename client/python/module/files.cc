// Features from files.
#include "dynmesh/files.h"

#include <pybind11/stl.h>

#include <optional>

#include "client/preparation/prepare.h"
#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/status.h"
#include "core/base/text.h"
#include "core/io/api/file_input.h"

namespace dynmesh::python {
namespace {

py::dict DictOf(const FileInput& file) {
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

py::dict Read(const std::string& path, bool merge_coplanar, bool polygons, bool refine,
              bool keep_facets) {
  absl::StatusOr<FileInput> input = absl::UnknownError("");
  {
    py::gil_scoped_release release;
    input = ReadInput(path, InputChoices{merge_coplanar, polygons, refine, keep_facets});
  }
  return DictOf(Value(std::move(input)));
}

// "mended" and so on: what was done, and how far the result is from the file.
py::dict ReadSurface(const std::string& path, std::optional<double> within,
                     std::optional<double> fill_holes, bool polygons, bool keep_facets) {
  absl::StatusOr<preparation::Prepared> prepared = absl::UnknownError("");
  {
    py::gil_scoped_release release;
    io::GeometryOptions reading;
    reading.polygons = polygons;
    reading.keep_facets = keep_facets;
    prepared = preparation::Prepare(path, reading, {within, fill_holes});
  }
  preparation::Prepared value = Value(std::move(prepared));
  const preparation::Report& report = value.report;
  py::dict told;
  told["mended"] = report.is_mended;
  told["thinned"] = report.is_thinned;
  if (report.is_thinned) {
    told["triangles_read"] = report.triangles_read;
    told["triangles"] = report.triangles;
  }
  told["found"] = std::string(text::View(report.found.message()));
  told["within"] = report.within;
  told["tolerance"] = report.tolerance;
  told["farthest"] = report.farthest;
  told["open_edges_read"] = report.open_edges;
  told["open_edges"] = report.open_edges_after;
  py::list loops;
  for (const preparation::OpenLoop& loop : report.open_loops) {
    py::dict row;
    row["points"] = loop.corners;
    row["length"] = loop.length;
    row["middle"] = loop.middle;
    loops.append(std::move(row));
  }
  told["open_loops"] = loops;
  told["unfilled"] = std::string(text::View(report.unfilled.message()));
  told["seconds"] = report.seconds;
  py::dict changes;
  for (const auto& [what, count] : report.changes) changes[py::str(what)] = count;
  told["changes"] = changes;
  py::dict result = DictOf(io::InputOf(std::move(value.geometry)));
  result["preparation"] = told;
  return result;
}

}  // namespace

void Write(const Mesh& mesh, const py::dict& options, const std::string& path,
           const py::dict& choices, bool is_part) {
  OutputChoices output;
  output.part = is_part;
  output.order = choices["order"].cast<int>();
  output.msh_version = choices["msh_version"].cast<double>();
  output.from_zero = choices["from_zero"].cast<bool>();
  output.neighbours = choices["neighbours"].cast<bool>();
  output.voronoi = choices["voronoi"].cast<bool>();
  output.input_markers = choices["input_markers"].cast<bool>();
  const MeshOptions made_with = OptionsOf(options);
  absl::Status status;
  {
    py::gil_scoped_release release;
    status = WriteMesh(mesh, made_with, path, output);
  }
  Check(status);
}

void BindFiles(py::module_& module) {
  module.def("read_input", &Read, py::arg("path"), py::arg("merge_coplanar"), py::arg("polygons"),
             py::arg("refine"), py::arg("keep_facets"));
  module.def("read_surface", &ReadSurface, py::arg("path"), py::arg("within"),
             py::arg("fill_holes"), py::arg("polygons"), py::arg("keep_facets"));
}

}  // namespace dynmesh::python
