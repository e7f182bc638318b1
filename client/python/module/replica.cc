// The replica in slots, its patches, and diffs.
#include <pybind11/stl.h>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/status.h"
#include "core/mesh_data/diff_meshes.h"

namespace dynmesh::python {
namespace {

// The boundary of a patch's cavity: the faces of its new simplices that they do not share with each
// other. Rows of slots: simplex, the corner opposite the face, the simplex beyond or -1.
py::array BoundaryFaces(const SlotMesh& mesh) {
  const auto width = static_cast<std::size_t>(mesh.dimension() + 1);
  const std::vector<Slot>& added = mesh.patch().added_simplices;
  std::vector<Slot> sorted = added;
  std::sort(sorted.begin(), sorted.end());
  std::vector<Slot> faces;
  for (const Slot slot : added) {
    for (std::size_t k = 0; k < width; ++k) {
      const Slot other = mesh.neighbours()[static_cast<std::size_t>(slot) * width + k];
      if (other != kNoSlot && std::binary_search(sorted.begin(), sorted.end(), other)) continue;
      faces.insert(faces.end(), {slot, static_cast<Slot>(k), other});
    }
  }
  return Take(std::move(faces), 3);
}

py::array CornersOf(const SlotMesh& mesh, const std::vector<Slot>& simplices) {
  const auto width = static_cast<std::size_t>(mesh.dimension() + 1);
  std::vector<Slot> corners;
  corners.reserve(simplices.size() * width);
  for (const Slot slot : simplices) {
    const Slot* const row = mesh.cells().data() + static_cast<std::size_t>(slot) * width;
    corners.insert(corners.end(), row, row + width);
  }
  return Take(std::move(corners), width);
}

py::dict PatchDict(const SlotMesh& mesh) {
  const MeshPatch& patch = mesh.patch();
  const auto width = static_cast<std::size_t>(mesh.dimension() + 1);
  py::dict d;
  d["from_revision"] = patch.from_revision;
  d["to_revision"] = patch.to_revision;
  d["removed_vertices"] = Take(patch.removed_vertices);
  d["added_vertices"] = Take(patch.added_vertices);
  d["removed_cells"] = Take(patch.removed_simplices);
  d["removed_corners"] = Take(patch.removed_corners, width);
  d["removed_regions"] = Take(patch.removed_regions);
  d["added_cells"] = Take(patch.added_simplices);
  d["added_corners"] = CornersOf(mesh, patch.added_simplices);
  d["relabelled_cells"] = Take(patch.relabelled_simplices);
  d["former_regions"] = Take(patch.former_regions);
  d["boundary_faces"] = BoundaryFaces(mesh);
  return d;
}

py::dict CompactDict(const SlotMesh& mesh) {
  const CompactNumbering numbering = mesh.Compact();
  const auto d = static_cast<std::size_t>(mesh.dimension()), width = d + 1;
  std::vector<double> points;
  points.reserve(numbering.vertex_slots.size() * d);
  for (const Slot slot : numbering.vertex_slots) {
    const double* const position = mesh.points().data() + static_cast<std::size_t>(slot) * d;
    points.insert(points.end(), position, position + d);
  }
  std::vector<std::int32_t> cells;
  cells.reserve(numbering.simplex_slots.size() * width);
  std::vector<RegionId> regions;
  for (const Slot slot : numbering.simplex_slots) {
    const Slot* const row = mesh.cells().data() + static_cast<std::size_t>(slot) * width;
    for (std::size_t k = 0; k < width; ++k) {
      cells.push_back(numbering.vertex_numbers[static_cast<std::size_t>(row[k])]);
    }
    regions.push_back(mesh.regions()[static_cast<std::size_t>(slot)]);
  }
  py::dict result;
  result["points"] = Take(std::move(points), d);
  result["cells"] = Take(std::move(cells), width);
  result["regions"] = Take(std::move(regions));
  result["vertex_slots"] = Take(std::vector<Slot>(numbering.vertex_slots));
  result["vertex_numbers"] = Take(std::vector<std::int32_t>(numbering.vertex_numbers));
  result["cell_slots"] = Take(std::vector<Slot>(numbering.simplex_slots));
  result["cell_numbers"] = Take(std::vector<std::int32_t>(numbering.simplex_numbers));
  return result;
}

py::dict WorkDict(const Diff& d) {
  const WorkCounters& work = d.diff.work;
  py::dict result;
  result["executed"] = work.executed, result["created"] = work.created;
  result["dropped"] = work.dropped, result["microseconds"] = work.microseconds;
  return result;
}

}  // namespace

void BindReplica(py::module_& module) {
  py::class_<Diff, std::shared_ptr<Diff>>(module, "Diff")
      .def_property_readonly("from_revision", [](const Diff& d) { return d.diff.from_revision; })
      .def_property_readonly("to_revision", [](const Diff& d) { return d.diff.to_revision; })
      .def_property_readonly("hash", [](const Diff& d) { return d.diff.hash.ToHex(); })
      .def_property_readonly("replayed", [](const Diff& d) { return d.replayed; })
      .def_property_readonly("work", &WorkDict)
      .def_property_readonly("labels", [](const Diff& d) { return LabelTuples(d.diff.labels); })
      .def_property_readonly("counts", [](const Diff& d) {
        return py::make_tuple(d.diff.removed_vertices.size(), d.diff.added_vertices.size(),
                              d.diff.removed_simplex_count(), d.diff.added_simplex_count());
      });

  py::class_<Mesh, std::shared_ptr<Mesh>>(module, "Snapshot")
      .def_property_readonly("revision", [](const Mesh& mesh) { return mesh.revision; })
      .def_property_readonly("hash", [](const Mesh& mesh) { return mesh.hash.ToHex(); });

  using Replica = SlotMesh;
  py::class_<Replica>(module, "Replica")
      .def(py::init([](const Mesh& mesh) {
             py::gil_scoped_release release;
             return Value(SlotMesh::FromMesh(mesh));
           }),
           py::arg("snapshot"))
      .def(
          "apply",
          [](Replica& replica, const Diff& d, bool extends) {
            py::gil_scoped_release release;
            Check(extends ? replica.Extend(d.diff) : replica.Apply(d.diff));
          },
          py::arg("diff"), py::arg("extends") = false)
      // The diff from the replica to a whole mesh of any revision.
      .def("diff_to",
           [](const Replica& replica, const Mesh& mesh) {
             py::gil_scoped_release release;
             return std::make_shared<Diff>(
                 Diff{mesh_data::DiffMeshes(replica.ToMesh(), mesh), false});
           })
      .def_property_readonly("dimension", &Replica::dimension)
      .def_property_readonly("revision", &Replica::revision)
      .def_property_readonly("hash", [](const Replica& r) { return r.hash().ToHex(); })
      .def_property_readonly("vertex_count", &Replica::vertex_count)
      .def_property_readonly("cell_count", &Replica::simplex_count)
      .def_property_readonly("vertex_slots", [](const Replica& r) { return r.ids().size(); })
      .def_property_readonly("cell_slots", [](const Replica& r) { return r.regions().size(); })
      .def_property_readonly("points",
                             [](const Replica& r) {
                               return View(r.points(), static_cast<std::size_t>(r.dimension()));
                             })
      .def_property_readonly("ids", [](const Replica& r) { return View(r.ids()); })
      .def_property_readonly("owners", [](const Replica& r) { return View(r.owners()); })
      .def_property_readonly("containing_dimensions",
                             [](const Replica& r) { return View(r.containing_dimensions()); })
      .def_property_readonly("cells",
                             [](const Replica& r) {
                               return View(r.cells(), static_cast<std::size_t>(r.dimension() + 1));
                             })
      .def_property_readonly("neighbours",
                             [](const Replica& r) {
                               return View(r.neighbours(),
                                           static_cast<std::size_t>(r.dimension() + 1));
                             })
      .def_property_readonly("regions", [](const Replica& r) { return View(r.regions()); })
      .def_property_readonly("subsegments",
                             [](const Replica& r) { return View(r.subsegments(), 2); })
      .def_property_readonly("subsegment_owners",
                             [](const Replica& r) { return View(r.subsegment_owners()); })
      .def_property_readonly("subfacets", [](const Replica& r) { return View(r.subfacets(), 3); })
      .def_property_readonly("subfacet_owners",
                             [](const Replica& r) { return View(r.subfacet_owners()); })
      .def_property_readonly("region_sets",
                             [](const Replica& r) {
                               py::dict sets;
                               for (const RegionSet& set : r.region_sets()) {
                                 sets[py::int_(set.id)] = py::tuple(py::cast(set.polygons));
                               }
                               return sets;
                             })
      .def_property_readonly("labels", [](const Replica& r) { return LabelTuples(r.labels()); })
      .def("compact", &CompactDict)
      .def("patch", &PatchDict)
      .def("find",
           [](const Replica& r, const InArray<std::uint64_t>& ids) {
             std::vector<Slot> slots;
             slots.reserve(static_cast<std::size_t>(ids.size()));
             for (const std::uint64_t id : SpanOf(ids)) slots.push_back(r.FindSlot(id));
             return Take(std::move(slots));
           })
      // Slots of simplices by the ids of their corners; -1 if there is none.
      .def("find_cells", [](const Replica& r, const InArray<std::uint64_t>& ids) {
        const auto width = static_cast<std::size_t>(r.dimension() + 1);
        const auto all = SpanOf(ids);
        std::vector<Slot> slots;
        for (std::size_t i = 0; i + width <= all.size(); i += width) {
          slots.push_back(r.FindSimplexSlot(all.subspan(i, width)));
        }
        return Take(std::move(slots));
      });
}

}  // namespace dynmesh::python
