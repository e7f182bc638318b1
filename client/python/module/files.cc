// Features from files.
#include "dynmesh/files.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "client/preparation/facet_map.h"
#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/progress_call.h"
#include "client/python/module/status.h"
#include "core/base/text.h"
#include "core/io/formats/geometry.h"
#include "dynmesh/surfaces.h"

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
                     std::optional<double> fill_holes, std::optional<double> mending_tolerance,
                     bool polygons, bool keep_facets, bool facets, bool try_mesh) {
  const SurfaceChoices choices = {within, fill_holes, mending_tolerance, polygons, keep_facets};
  absl::StatusOr<PreparedSurface> prepared = absl::UnknownError("");
  absl::StatusOr<std::vector<FeatureId>> of_facets = std::vector<FeatureId>();
  std::vector<std::string> attempts;
  const py::none no_callback;
  ProgressCall call(no_callback);  // asks for Ctrl-C
  {
    py::gil_scoped_release release;
    if (try_mesh) {
      BuildOptions build;
      build.progress = [&](const ApplyProgress&) { call("", 0, 0); };
      build.interrupted = [cancelled = call.cancelled()] { return cancelled->load(); };
      absl::StatusOr<SurfaceMesh> made = BuildSurface(path, choices, build);
      if (made.ok()) {
        prepared = std::move(made->surface);
        attempts = std::move(made->attempts);
      } else {
        prepared = made.status();
      }
    } else {
      prepared = PrepareSurface(path, choices);
    }
    if (prepared.ok() && facets) {
      io::Geometry geometry;
      geometry.options = prepared->input.options;
      geometry.features = prepared->input.features;
      of_facets = preparation::PolygonsOfFacets(path, geometry, prepared->report.within);
    }
  }
  call.RaiseIf(!prepared.ok());
  const PreparedSurface value = Value(std::move(prepared));
  const SurfaceReport& report = value.report;
  py::dict told;
  told["mended"] = report.mended;
  told["thinned"] = report.thinned;
  if (report.thinned) {
    told["triangles_read"] = report.triangles_read;
    told["triangles"] = report.triangles;
  }
  told["found"] = std::string(text::View(report.found.message()));
  told["within"] = report.within;
  told["tolerance"] = report.tolerance;
  told["least_tolerance"] = report.least_tolerance;
  told["larger_tolerance"] = report.larger_tolerance;
  told["attempts"] = attempts;
  told["farthest"] = report.farthest;
  told["open_edges_read"] = report.open_edges_read;
  told["open_edges"] = report.open_edges;
  py::list loops;
  for (const SurfaceLoop& loop : report.open_loops) {
    py::dict row;
    row["points"] = loop.points;
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
  py::dict result = DictOf(value.input);
  result["preparation"] = told;
  result["facets"] = Value(std::move(of_facets));
  return result;
}

void WriteAs(const Mesh& mesh, const MeshOptions& made_with, const std::string& path,
             const py::dict& choices, bool is_part) {
  OutputChoices output;
  output.part = is_part;
  output.order = choices["order"].cast<int>();
  output.msh_version = choices["msh_version"].cast<double>();
  output.binary = choices["binary"].cast<bool>();
  output.from_zero = choices["from_zero"].cast<bool>();
  output.neighbours = choices["neighbours"].cast<bool>();
  output.voronoi = choices["voronoi"].cast<bool>();
  output.input_markers = choices["input_markers"].cast<bool>();
  absl::Status status;
  {
    py::gil_scoped_release release;
    status = WriteMesh(mesh, made_with, path, output);
  }
  Check(status);
}

// A planar mesh of rows that are of no one mesh: vertices have their numbers as ids. `regions` has
// a row for each cell, `owners` one for each of the edges, `labels` are tuples of id, marker and
// name.
void WriteRows(const InArray<double>& points, const InArray<std::int32_t>& cells,
               const InArray<RegionId>& regions, const InArray<std::int32_t>& edges,
               const InArray<FeatureId>& owners, const py::list& labels, const std::string& path,
               const py::dict& choices) {
  constexpr VertexId kFirst = 1;  // ids are never 0
  Mesh mesh;
  const auto coordinates = SpanOf(points);
  mesh.vertices.coordinates.assign(coordinates.begin(), coordinates.end());
  const std::size_t count = coordinates.size() / 2;
  for (std::size_t number = 0; number < count; ++number) {
    mesh.vertices.ids.push_back(kFirst + number);
  }
  mesh.vertices.containing_dimensions.assign(count, 2);
  mesh.vertices.owners.assign(count, kNoFeature);
  const auto id_of = [&](std::int32_t number) {
    Require(number >= 0 && static_cast<std::size_t>(number) < count, "no vertex has this number");
    return kFirst + static_cast<VertexId>(number);
  };
  for (const std::int32_t corner : SpanOf(cells)) mesh.simplices.push_back(id_of(corner));
  for (std::size_t first = 0; first + 3 <= mesh.simplices.size(); first += 3) {  // the least id
    const auto corners = mesh.simplices.begin() + static_cast<std::ptrdiff_t>(first);
    std::rotate(corners, std::min_element(corners, corners + 3), corners + 3);
  }
  const auto of_cells = SpanOf(regions);
  mesh.regions.assign(of_cells.begin(), of_cells.end());
  const auto ends = SpanOf(edges);
  const auto of_edges = SpanOf(owners);
  Require(mesh.regions.size() * 3 == mesh.simplices.size() && of_edges.size() * 2 == ends.size(),
          "a region for each cell and an owner for each edge");
  for (std::size_t edge = 0; edge < of_edges.size(); ++edge) {
    const VertexId a = id_of(ends[2 * edge]), b = id_of(ends[2 * edge + 1]);
    mesh.subsegments.ends.insert(mesh.subsegments.ends.end(), {std::min(a, b), std::max(a, b)});
    mesh.subsegments.owners.push_back(of_edges[edge]);
    for (const VertexId end : {a, b}) {
      mesh.vertices.containing_dimensions[end - kFirst] = 1;
      mesh.vertices.owners[end - kFirst] = of_edges[edge];
    }
  }
  for (const py::handle& row : labels) {
    const auto [id, marker, name] = row.cast<std::tuple<FeatureId, std::int64_t, std::string>>();
    mesh.labels.push_back({id, FeatureLabel{marker, name}});
  }
  WriteAs(mesh, MeshOptions{}, path, choices, /*is_part=*/true);
}

}  // namespace

void Write(const Mesh& mesh, const py::dict& options, const std::string& path,
           const py::dict& choices, bool is_part) {
  WriteAs(mesh, OptionsOf(options), path, choices, is_part);
}

void BindFiles(py::module_& module) {
  module.def("read_input", &Read, py::arg("path"), py::arg("merge_coplanar"), py::arg("polygons"),
             py::arg("refine"), py::arg("keep_facets"));
  module.def("read_surface", &ReadSurface, py::arg("path"), py::arg("within"),
             py::arg("fill_holes"), py::arg("mending_tolerance"), py::arg("polygons"),
             py::arg("keep_facets"), py::arg("facets"), py::arg("try_mesh"));
  module.def("write_rows", &WriteRows, py::arg("points"), py::arg("cells"), py::arg("regions"),
             py::arg("edges"), py::arg("owners"), py::arg("labels"), py::arg("path"),
             py::arg("choices"));
}

}  // namespace dynmesh::python
