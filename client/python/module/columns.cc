// Meshes and diffs from columns, and batches as dicts: for a client that is written in Python.
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/status.h"
#include "core/mesh_data/regions.h"

namespace dynmesh::python {
namespace {

template <class T>
std::vector<T> Column(const py::dict& columns, const char* name) {
  const auto array = py::cast<InArray<T>>(columns[name]);
  const auto values = SpanOf(array);
  return {values.begin(), values.end()};
}

VertexColumns Vertices(const py::dict& columns) {
  return {Column<VertexId>(columns, "vertices"), Column<double>(columns, "coordinates"),
          Column<std::uint8_t>(columns, "containing_dimensions"),
          Column<FeatureId>(columns, "owners")};
}

template <class Columns>
Columns Constraints(const py::dict& columns, const std::string& name) {
  return {Column<VertexId>(columns, name.c_str()),
          Column<FeatureId>(columns, (name + "_owners").c_str())};
}

std::vector<RegionSet> Sets(const py::dict& columns) {
  std::vector<RegionSet> sets;
  for (const py::handle row : columns["region_sets"]) {
    auto [id, polygons] = py::cast<std::pair<RegionId, std::vector<FeatureId>>>(row);
    sets.push_back({id, std::move(polygons)});
  }
  if (!mesh_data::AreRegionSets(sets)) {
    throw StatusError(absl::DataLossError("the server sent a region set that is none"));
  }
  return sets;
}

LabelColumn Labels(const py::dict& columns) {
  LabelColumn labels;
  for (const py::handle row : columns["labels"]) {
    auto [id, marker, name] = py::cast<std::tuple<FeatureId, std::int64_t, std::string>>(row);
    labels.push_back({id, {marker, std::move(name)}});
  }
  return labels;
}

std::shared_ptr<Mesh> SnapshotOf(const py::dict& columns) {
  Mesh mesh;
  mesh.dimension = py::cast<int>(columns["dimension"]);
  mesh.revision = py::cast<std::uint64_t>(columns["revision"]);
  mesh.hash = Value(MeshHash::FromHex(py::cast<std::string>(columns["hash"])));
  mesh.vertices = Vertices(columns);
  mesh.simplices = Column<VertexId>(columns, "simplices");
  mesh.regions = Column<RegionId>(columns, "regions");
  mesh.subsegments = Constraints<SubsegmentColumns>(columns, "subsegments");
  mesh.subfacets = Constraints<SubfacetColumns>(columns, "subfacets");
  mesh.region_sets = Sets(columns);
  mesh_data::KeepNamed(mesh.region_sets, {&mesh.regions});
  mesh.labels = Labels(columns);
  return std::make_shared<Mesh>(std::move(mesh));
}

std::shared_ptr<Diff> DiffOf(const py::dict& columns) {
  MeshDiff diff;
  diff.dimension = py::cast<int>(columns["dimension"]);
  diff.from_revision = py::cast<std::uint64_t>(columns["from_revision"]);
  diff.to_revision = py::cast<std::uint64_t>(columns["to_revision"]);
  diff.hash = Value(MeshHash::FromHex(py::cast<std::string>(columns["hash"])));
  diff.removed_vertices = Column<VertexId>(columns, "removed_vertices");
  diff.removed_simplices = Column<VertexId>(columns, "removed_simplices");
  diff.removed_regions = Column<RegionId>(columns, "removed_regions");
  diff.removed_subsegments = Constraints<SubsegmentColumns>(columns, "removed_subsegments");
  diff.removed_subfacets = Constraints<SubfacetColumns>(columns, "removed_subfacets");
  diff.added_vertices = Vertices(columns);
  diff.added_simplices = Column<VertexId>(columns, "simplices");
  diff.added_regions = Column<RegionId>(columns, "regions");
  diff.added_subsegments = Constraints<SubsegmentColumns>(columns, "subsegments");
  diff.added_subfacets = Constraints<SubfacetColumns>(columns, "subfacets");
  diff.region_sets = Sets(columns);
  mesh_data::KeepNamed(diff.region_sets, {&diff.removed_regions, &diff.added_regions});
  diff.labels = Labels(columns);
  const py::dict work = columns["work"];
  for (const auto& [name, count] :
       {std::pair("executed", &diff.work.executed), std::pair("created", &diff.work.created),
        std::pair("dropped", &diff.work.dropped), std::pair("notified", &diff.work.notified),
        std::pair("visited_cells", &diff.work.visited_cells),
        std::pair("visited_nodes", &diff.work.visited_nodes)}) {
    *count = py::cast<std::uint64_t>(work[name]);
  }
  diff.work.microseconds = py::cast<double>(work["microseconds"]);
  diff.work.validate_microseconds = py::cast<double>(work["validate_microseconds"]);
  diff.work.diff_microseconds = py::cast<double>(work["diff_microseconds"]);
  return std::make_shared<Diff>(Diff{std::move(diff), py::cast<bool>(columns["replayed"])});
}

const char* NameOf(Edit::Action action) {
  switch (action) {
    case Edit::Action::kAdd:
      return "add";
    case Edit::Action::kSet:
      return "set";
    case Edit::Action::kRemove:
      return "remove";
    case Edit::Action::kMove:
      return "move";
    case Edit::Action::kSetLabel:
      return "label";
  }
  return "";
}

// Pairs of an action and the feature as a dict.
py::list EditDicts(const Batch& batch) {
  std::vector<Feature> features;
  features.reserve(batch.edits.size());
  for (const Edit& edit : batch.edits) features.push_back(edit.feature);
  const py::list dicts = FeatureDicts(features, batch.dimension);
  py::list result;
  for (std::size_t i = 0; i < batch.edits.size(); ++i) {
    result.append(py::make_tuple(NameOf(batch.edits[i].action), dicts[i]));
  }
  return result;
}

}  // namespace

void BindColumns(py::module_& module) {
  module.def("snapshot_of", &SnapshotOf);
  module.def("diff_of", &DiffOf);
  module.def("edits_of", &EditDicts);
  // All options of a mesh, with those that are not given.
  module.def("all_options",
             [](const py::dict& options) { return OptionsDict(OptionsOf(options)); });
}

}  // namespace dynmesh::python
