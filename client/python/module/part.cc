// Parts of meshes that follow their diffs.
#include "dynmesh/part.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/held_column.h"
#include "client/python/module/shared_mesh.h"
#include "client/python/module/status.h"
#include "core/io/meshes/region_labels.h"

namespace dynmesh::python {
namespace {

using Numbers = std::int32_t;

// A region as in files: its small number, and the label of the polygon whose own it is.
struct RegionRow {
  std::uint32_t number = 0;
  io::RegionLabel label = {};
};

// A part that threads share. Its lock is taken after that of the mesh.
class SharedPart {
 public:
  SharedPart(SharedMesh& mesh, PartChoice choice)
      : dimension_(mesh.dimension()), part_(Make(mesh, std::move(choice))) {}

  absl::Status Update(SharedMesh& mesh, const std::vector<const MeshDiff*>& diffs) {
    const MutexLock mesh_lock(mesh.mutex());
    const MutexLock lock(mutex_);
    const std::size_t vertices = part_.vertex_slots().size(), cells = part_.cell_slots().size(),
                      facets = part_.facet_owners().size(), slots = part_.vertex_numbers().size(),
                      cell_slots = part_.cell_numbers().size();
    if (absl::Status s = part_.Update(mesh.replica(), diffs); !s.ok()) return s;
    const MeshPart::Changes& changes = part_.changes();
    const bool all = changes.is_all;
    Add(vertex_log_, all, changes.vertices, vertices, part_.vertex_slots().size());
    Add(cell_log_, all, changes.cells, cells, part_.cell_slots().size());
    Add(facet_log_, all, changes.facets, facets, part_.facet_owners().size());
    Add(vertex_number_log_, all, changes.vertex_slots, slots, part_.vertex_numbers().size());
    Add(cell_number_log_, all, changes.cell_slots, cell_slots, part_.cell_numbers().size());
    points_.DropOld(vertex_log_), vertex_slots_.DropOld(vertex_log_);
    origin_.DropOld(vertex_log_), facet_twins_.DropOld(facet_log_);
    cells_.DropOld(cell_log_), cell_slots_.DropOld(cell_log_), regions_.DropOld(cell_log_);
    facets_.DropOld(facet_log_), owners_.DropOld(facet_log_), facet_cells_.DropOld(facet_log_);
    vertex_numbers_.DropOld(vertex_number_log_), cell_numbers_.DropOld(cell_number_log_);
    return absl::OkStatus();
  }

  absl::StatusOr<Mesh> ToMesh(SharedMesh& mesh) {
    const MutexLock mesh_lock(mesh.mutex());
    const MutexLock lock(mutex_);
    return part_.ToMesh(mesh.replica());
  }

  absl::StatusOr<std::vector<std::int8_t>> FacetSides(SharedMesh& mesh,
                                                      const std::vector<Feature>& features) {
    const MutexLock mesh_lock(mesh.mutex());
    const MutexLock lock(mutex_);
    return part_.FacetSides(mesh.replica(), features);
  }

  absl::StatusOr<std::vector<std::int32_t>> CellsAround(SharedMesh& mesh,
                                                        std::span<const std::int32_t> vertices) {
    const MutexLock mesh_lock(mesh.mutex());
    const MutexLock lock(mutex_);
    return part_.CellsAround(mesh.replica(), vertices);
  }

  // Of each region of the part what files give it.
  absl::StatusOr<std::map<RegionId, RegionRow>> RegionLabels(SharedMesh& mesh);

  int dimension() const { return dimension_; }
  std::uint64_t revision() {
    const MutexLock lock(mutex_);
    return part_.revision();
  }

  MeshPart::Changes changes() {
    const PatientLock lock(mutex_);
    return part_.changes();
  }

  HeldColumn<double> points() { return Take(points_, part_.points(), Width(0), vertex_log_); }
  HeldColumn<Slot> vertex_slots() {
    return Take(vertex_slots_, part_.vertex_slots(), 1, vertex_log_);
  }
  HeldColumn<Numbers> origin() { return Take(origin_, part_.origin(), 1, vertex_log_); }
  HeldColumn<Numbers> cells() { return Take(cells_, part_.cells(), Width(1), cell_log_); }
  HeldColumn<Slot> cell_slots() { return Take(cell_slots_, part_.cell_slots(), 1, cell_log_); }
  HeldColumn<RegionId> regions() { return Take(regions_, part_.cell_regions(), 1, cell_log_); }
  HeldColumn<Numbers> facets() { return Take(facets_, part_.facets(), Width(0), facet_log_); }
  HeldColumn<FeatureId> owners() { return Take(owners_, part_.facet_owners(), 1, facet_log_); }
  HeldColumn<Slot> facet_cells() { return Take(facet_cells_, part_.facet_cells(), 2, facet_log_); }
  HeldColumn<Numbers> facet_twins() {
    return Take(facet_twins_, part_.facet_twins(), 1, facet_log_);
  }
  HeldColumn<Numbers> vertex_numbers() {
    return Take(vertex_numbers_, part_.vertex_numbers(), 1, vertex_number_log_);
  }
  HeldColumn<Numbers> cell_numbers() {
    return Take(cell_numbers_, part_.cell_numbers(), 1, cell_number_log_);
  }

 private:
  static MeshPart Make(SharedMesh& mesh, PartChoice choice) {
    const MutexLock lock(mesh.mutex());
    return MeshPart(mesh.replica(), std::move(choice));
  }
  std::size_t Width(int more) const { return static_cast<std::size_t>(dimension_ + more); }

  static void Add(RowLog& log, bool is_all, std::vector<std::int32_t> rows, std::size_t former,
                  std::size_t size) {
    // The last rows may have gone, and no other row have changed: that is a change, too.
    if (rows.empty() && size != former) rows.push_back(0);
    is_all ? log.AddUnknown() : log.Add(std::move(rows), size / 4 + 64);
  }

  template <class T>
  HeldColumn<T> Take(ColumnCopies<T>& copies, const SlotColumn<T>& column, std::size_t width,
                     const RowLog& log) {
    const PatientLock lock(mutex_);
    return copies.Take(column, width, log);
  }

  const int dimension_;
  Mutex mutex_;
  MeshPart part_;
  RowLog vertex_log_, cell_log_, facet_log_, vertex_number_log_, cell_number_log_;
  ColumnCopies<double> points_;
  ColumnCopies<Slot> vertex_slots_, cell_slots_, facet_cells_;
  ColumnCopies<Numbers> origin_, cells_, facets_, facet_twins_, vertex_numbers_, cell_numbers_;
  ColumnCopies<RegionId> regions_;
  ColumnCopies<FeatureId> owners_;
};

absl::StatusOr<std::map<RegionId, RegionRow>> SharedPart::RegionLabels(SharedMesh& mesh) {
  const MutexLock mesh_lock(mesh.mutex());
  const MutexLock lock(mutex_);
  const SlotMesh& whole = mesh.replica();
  if (whole.revision() != part_.revision()) {
    return absl::FailedPreconditionError(
        "the part is not at the mesh's revision: update the part first");
  }
  std::map<RegionId, RegionRow> rows;
  const SlotColumn<RegionId>& regions = part_.cell_regions();
  for (std::size_t cell = 0; cell < regions.size(); ++cell) rows[regions[cell]];
  // Numbers are in the order of the polygons.
  const std::vector<RegionSet> sets = whole.region_sets();
  std::vector<std::pair<std::vector<FeatureId>, RegionId>> order;
  for (const auto& [region, row] : rows) {
    if (region != kNoRegion) order.emplace_back(PolygonsOf(region, sets), region);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::vector<FeatureId>> polygons;
  for (auto& [of_one, region] : order) {
    polygons.push_back(std::move(of_one));
    rows[region].number = static_cast<std::uint32_t>(polygons.size());
  }
  io::RegionScene scene;
  scene.dimension = dimension_;
  scene.polygons = polygons;
  const auto region_at = [&](Slot cell) {
    return cell == kNoSlot ? 0 : rows[whole.regions()[static_cast<std::size_t>(cell)]].number;
  };
  for (std::size_t facet = 0; facet < part_.facet_owners().size(); ++facet) {
    const FeatureId owner = part_.facet_owners()[facet];
    if (owner == kNoFeature) continue;
    // Across what is opened is the first cell of the twin.
    const std::int32_t twin = part_.facet_twins()[facet];
    const Slot beyond = twin < 0 ? part_.facet_cells()[2 * facet + 1]
                                 : part_.facet_cells()[2 * static_cast<std::size_t>(twin)];
    scene.facets.push_back({owner, {region_at(part_.facet_cells()[2 * facet]), region_at(beyond)}});
  }
  const auto labels = io::RegionLabelsOf(scene, io::FromLabelColumn(whole.labels()));
  for (auto& [region, row] : rows) row.label = labels[row.number];
  return rows;
}

// A getter of a column: rows of `more` entries more than the dimension, or of `fixed`; 0: one.
template <class T>
auto Column(HeldColumn<T> (SharedPart::*column)(), int more) {
  return [=](SharedPart& part) {
    return View((part.*column)(), static_cast<std::size_t>(part.dimension() + more));
  };
}
template <class T>
auto Fixed(HeldColumn<T> (SharedPart::*column)(), std::size_t width = 0) {
  return [=](SharedPart& part) { return View((part.*column)(), width); };
}

}  // namespace

void BindPart(py::module_& module) {
  py::class_<SharedPart>(module, "Part")
      .def(py::init([](SharedMesh& mesh, std::vector<FeatureId> polygons,
                       std::vector<std::string> names, bool inside, std::vector<FeatureId> without,
                       std::vector<FeatureId> open, std::vector<std::string> open_names) {
             py::gil_scoped_release release;
             return std::make_unique<SharedPart>(
                 mesh, PartChoice{std::move(polygons), std::move(names), inside, std::move(without),
                                  std::move(open), std::move(open_names)});
           }),
           py::arg("mesh"), py::arg("polygons"), py::arg("names"), py::arg("inside"),
           py::arg("without"), py::arg("open"), py::arg("open_names"))
      .def(
          "update",
          [](SharedPart& part, SharedMesh& mesh, const std::vector<std::shared_ptr<Diff>>& diffs) {
            std::vector<const MeshDiff*> all;
            for (const auto& diff : diffs) all.push_back(&diff->diff);
            absl::Status status;
            {
              py::gil_scoped_release release;
              status = part.Update(mesh, all);
            }
            Check(status);
          },
          py::arg("mesh"), py::arg("diffs"))
      .def(
          "write",
          [](SharedPart& part, SharedMesh& mesh, const py::dict& options, const std::string& path,
             const py::dict& choices) {
            absl::StatusOr<Mesh> own = absl::UnknownError("");
            {
              py::gil_scoped_release release;
              own = part.ToMesh(mesh);
            }
            Write(Value(std::move(own)), options, path, choices, /*is_part=*/true);
          },
          py::arg("mesh"), py::arg("options"), py::arg("path"), py::arg("choices"))
      .def(
          "cells_around",
          [](SharedPart& part, SharedMesh& mesh, const InArray<std::int32_t>& vertices) {
            absl::StatusOr<std::vector<std::int32_t>> around = absl::UnknownError("");
            {
              const auto numbers = SpanOf(vertices);
              py::gil_scoped_release release;
              around = part.CellsAround(mesh, numbers);
            }
            return Take(Value(std::move(around)));
          },
          py::arg("mesh"), py::arg("vertices"))
      .def(
          "facet_sides",
          [](SharedPart& part, SharedMesh& mesh, const Batch& batch) {
            absl::StatusOr<std::vector<std::int8_t>> sides = absl::UnknownError("");
            {
              py::gil_scoped_release release;
              std::vector<Feature> features;
              for (const dynmesh::Edit& edit : batch.edits) features.push_back(edit.feature);
              sides = part.FacetSides(mesh, features);
            }
            return Take(Value(std::move(sides)));
          },
          py::arg("mesh"), py::arg("features"))
      .def(
          "region_labels",
          [](SharedPart& part, SharedMesh& mesh) {
            absl::StatusOr<std::map<RegionId, RegionRow>> labels = absl::UnknownError("");
            {
              py::gil_scoped_release release;
              labels = part.RegionLabels(mesh);
            }
            py::dict result;
            for (const auto& [region, row] : Value(std::move(labels))) {
              result[py::int_(region)] =
                  py::make_tuple(row.number, row.label.marker, row.label.name);
            }
            return result;
          },
          py::arg("mesh"))
      .def_property_readonly("revision", &SharedPart::revision)
      .def_property_readonly("changes",
                             [](SharedPart& part) {
                               MeshPart::Changes changes = part.changes();
                               if (changes.is_all) return py::make_tuple(py::none(), py::none());
                               return py::make_tuple(Take(std::move(changes.vertices)),
                                                     Take(std::move(changes.cells)));
                             })
      .def_property_readonly("points", Column(&SharedPart::points, 0))
      .def_property_readonly("cells", Column(&SharedPart::cells, 1))
      .def_property_readonly("facets", Column(&SharedPart::facets, 0))
      .def_property_readonly("facet_cells", Fixed(&SharedPart::facet_cells, 2))
      .def_property_readonly("facet_owners", Fixed(&SharedPart::owners))
      .def_property_readonly("facet_twins", Fixed(&SharedPart::facet_twins))
      .def_property_readonly("origin", Fixed(&SharedPart::origin))
      .def_property_readonly("cell_regions", Fixed(&SharedPart::regions))
      .def_property_readonly("vertex_slots", Fixed(&SharedPart::vertex_slots))
      .def_property_readonly("cell_slots", Fixed(&SharedPart::cell_slots))
      .def_property_readonly("vertex_numbers", Fixed(&SharedPart::vertex_numbers))
      .def_property_readonly("cell_numbers", Fixed(&SharedPart::cell_numbers));
}

}  // namespace dynmesh::python
