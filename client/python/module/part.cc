// Parts of meshes that follow their diffs.
#include "dynmesh/part.h"

#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/held_column.h"
#include "client/python/module/shared_mesh.h"
#include "client/python/module/status.h"

namespace dynmesh::python {
namespace {

using Numbers = std::int32_t;

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
