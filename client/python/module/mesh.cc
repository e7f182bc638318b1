// Meshes in slots, their patches and diffs: in this process, or replicas of a server's.
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/progress_call.h"
#include "client/python/module/shared_mesh.h"
#include "client/python/module/status.h"
#include "core/base/memory_budget.h"
#include "core/mesh_data/diff_meshes.h"

namespace dynmesh::python {
namespace {

const char* NameOf(ApplyProgress::Stage stage) {
  switch (stage) {
    case ApplyProgress::Stage::kValidate:
      return "validate";
    case ApplyProgress::Stage::kRefine:
      return "refine";
    case ApplyProgress::Stage::kDiff:
      return "diff";
  }
  return "";
}

std::unique_ptr<SharedMesh> Open(const py::dict& options) {
  const MeshOptions asked = OptionsOf(options);
  py::gil_scoped_release release;
  return Value(SharedMesh::Create(asked));
}

std::shared_ptr<Diff> Edit(SharedMesh& mesh, const Batch& batch, const py::object& progress) {
  ApplyOptions options;
  ProgressCall call(progress);
  // An edit that ends soon does not ask what is left.
  std::uint32_t calls = 0;
  std::optional<MemoryBudget> budget;
  options.interrupted = [&, cancelled = call.cancelled()] {
    if (cancelled->load(std::memory_order_relaxed)) return true;
    if (++calls < MemoryBudget::kCallsBetweenLooks) return false;
    if (!budget) budget = MemoryBudget::OfWhatIsLeft();
    return budget->IsExceeded();
  };
  options.progress = [&](const ApplyProgress& p) { call(NameOf(p.stage), p.done, p.total); };
  absl::StatusOr<MeshDiff> diff = absl::UnknownError("");
  {
    py::gil_scoped_release release;
    diff = mesh.Edit(batch.edits, options);
  }
  call.RaiseIf(!diff.ok());
  if (absl::IsCancelled(diff.status()) && budget && budget->was_exceeded()) {
    diff = budget->Error("fewer features, larger sizes or max_vertices keep it smaller");
  }
  return std::make_shared<Diff>(Diff{Value(std::move(diff)), false});
}

py::list Features(SharedMesh& mesh) {
  absl::StatusOr<std::vector<Feature>> features = absl::UnknownError("");
  {
    py::gil_scoped_release release;
    features = mesh.Features();
  }
  return FeatureDicts(Value(std::move(features)), mesh.dimension());
}

py::array Locate(SharedMesh& mesh, const InArray<double>& points) {
  absl::StatusOr<std::vector<Slot>> slots = absl::UnknownError("");
  {
    const auto places = SpanOf(points);
    py::gil_scoped_release release;
    slots = mesh.Locate(places);
  }
  return Take(Value(std::move(slots)));
}

py::dict PatchDict(const SharedMesh& mesh) {
  PatchColumns columns;
  {
    py::gil_scoped_release release;
    columns = mesh.TakePatch();
  }
  MeshPatch& patch = columns.patch;
  const auto width = static_cast<std::size_t>(mesh.dimension() + 1);
  py::dict d;
  d["from_revision"] = patch.from_revision;
  d["to_revision"] = patch.to_revision;
  d["removed_vertices"] = Take(std::move(patch.removed_vertices));
  d["added_vertices"] = Take(std::move(patch.added_vertices));
  d["removed_cells"] = Take(std::move(patch.removed_simplices));
  d["removed_corners"] = Take(std::move(patch.removed_corners), width);
  d["removed_regions"] = Take(std::move(patch.removed_regions));
  d["added_cells"] = Take(std::move(patch.added_simplices));
  d["added_corners"] = Take(std::move(columns.added_corners), width);
  d["relabelled_cells"] = Take(std::move(patch.relabelled_simplices));
  d["former_regions"] = Take(std::move(patch.former_regions));
  d["boundary_faces"] = Take(std::move(columns.boundary_faces), 3);
  return d;
}

py::dict CompactDict(const SharedMesh& mesh) {
  CompactColumns columns;
  {
    py::gil_scoped_release release;
    columns = mesh.TakeCompact();
  }
  CompactNumbering& numbering = columns.numbering;
  const auto d = static_cast<std::size_t>(mesh.dimension());
  py::dict result;
  result["points"] = Take(std::move(columns.points), d);
  result["cells"] = Take(std::move(columns.cells), d + 1);
  result["regions"] = Take(std::move(columns.regions));
  result["vertex_slots"] = Take(std::move(numbering.vertex_slots));
  result["vertex_numbers"] = Take(std::move(numbering.vertex_numbers));
  result["cell_slots"] = Take(std::move(numbering.simplex_slots));
  result["cell_numbers"] = Take(std::move(numbering.simplex_numbers));
  return result;
}

py::dict WorkDict(const Diff& d) {
  const WorkCounters& work = d.diff.work;
  py::dict result;
  result["executed"] = work.executed, result["created"] = work.created;
  result["dropped"] = work.dropped, result["microseconds"] = work.microseconds;
  result["notified"] = work.notified;
  return result;
}

py::array Find(SharedMesh& mesh, const InArray<std::uint64_t>& ids) {
  const auto wanted = SpanOf(ids);
  std::vector<Slot> slots(wanted.size(), kNoSlot);
  {
    const PatientLock lock(mesh.mutex());
    for (std::size_t i = 0; i < wanted.size(); ++i) slots[i] = mesh.replica().FindSlot(wanted[i]);
  }
  return Take(std::move(slots));
}

// Slots of simplices by the ids of their corners; -1 if there is none.
py::array FindCells(SharedMesh& mesh, const InArray<std::uint64_t>& ids) {
  const auto width = static_cast<std::size_t>(mesh.dimension() + 1);
  const auto all = SpanOf(ids);
  std::vector<Slot> slots;
  slots.reserve(all.size() / width);
  {
    const PatientLock lock(mesh.mutex());
    for (std::size_t i = 0; i + width <= all.size(); i += width) {
      slots.push_back(mesh.replica().FindSimplexSlot(all.subspan(i, width)));
    }
  }
  return Take(std::move(slots));
}

// The diff from the mesh to a whole mesh of any revision.
std::shared_ptr<Diff> DiffTo(SharedMesh& mesh, const Mesh& whole) {
  py::gil_scoped_release release;
  const MutexLock lock(mesh.mutex());
  return std::make_shared<Diff>(Diff{mesh_data::DiffMeshes(mesh.replica().ToMesh(), whole), false});
}

py::dict RegionSets(SharedMesh& mesh) {
  const auto sets = [&mesh] {
    const PatientLock lock(mesh.mutex());
    return mesh.replica().region_sets();
  }();
  py::dict result;
  for (const RegionSet& set : sets) result[py::int_(set.id)] = py::tuple(py::cast(set.polygons));
  return result;
}

// A getter of a column, with `width(dimension)` entries a row, 0: one-dimensional.
template <class T, class Width>
auto Column(HeldColumn<T> (SharedMesh::*column)(), Width width) {
  return [column, width](SharedMesh& mesh) {
    HeldColumn<T> held = [column, &mesh] {
      const PatientLock lock(mesh.mutex());
      return (mesh.*column)();
    }();
    return View(std::move(held), width(mesh.dimension()));
  };
}
template <class T>
auto Column(HeldColumn<T> (SharedMesh::*column)()) {
  return Column(column, [](int) { return std::size_t{0}; });
}

void BindData(py::module_& module) {
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
}

// Of a mesh in this process alone.
void BindEditing(py::class_<SharedMesh>& mesh) {
  mesh.def("edit", &Edit, py::arg("batch"), py::arg("progress") = py::none())
      .def("validate",
           [](SharedMesh& m, const Batch& batch) {
             py::gil_scoped_release release;
             Check(m.Validate(batch.edits));
           })
      .def("features", &Features)
      .def("locate", &Locate)
      .def("options", [](const SharedMesh& m) { return OptionsDict(m.options()); })
      .def("audit", [](SharedMesh& m) {
        absl::StatusOr<AuditReport> report = absl::UnknownError("");
        {
          py::gil_scoped_release release;
          report = m.Audit();
        }
        return py::cast(Value(std::move(report)).problems);
      });
}

}  // namespace

void BindMesh(py::module_& module) {
  BindData(module);
  module.def("open_mesh", &Open, py::arg("options"));
  py::class_<SharedMesh> mesh(module, "Mesh");
  const auto dimension = [](int d) { return static_cast<std::size_t>(d); };
  const auto corners = [](int d) { return static_cast<std::size_t>(d + 1); };
  const auto fixed = [](std::size_t n) { return [n](int) { return n; }; };
  const auto number = [](auto member) {
    return [member](const SharedMesh& m) { return m.numbers().*member; };
  };
  mesh.def(py::init([](const Mesh& snapshot) {
             py::gil_scoped_release release;
             return Value(SharedMesh::FromSnapshot(snapshot));
           }),
           py::arg("snapshot"))
      .def(
          "apply",
          [](SharedMesh& m, const Diff& d, bool extends) {
            py::gil_scoped_release release;
            Check(m.Apply(d.diff, extends));
          },
          py::arg("diff"), py::arg("extends") = false)
      .def("diff_to", &DiffTo)
      .def_property_readonly("dimension", &SharedMesh::dimension)
      .def_property_readonly("revision", number(&MeshNumbers::revision))
      .def_property_readonly("hash", [](const SharedMesh& m) { return m.numbers().hash.ToHex(); })
      .def_property_readonly("vertex_count", number(&MeshNumbers::vertices))
      .def_property_readonly("cell_count", number(&MeshNumbers::simplices))
      .def_property_readonly("vertex_slots", number(&MeshNumbers::vertex_slots))
      .def_property_readonly("cell_slots", number(&MeshNumbers::cell_slots))
      .def_property_readonly("points", Column(&SharedMesh::points, dimension))
      .def_property_readonly("ids", Column(&SharedMesh::ids))
      .def_property_readonly("owners", Column(&SharedMesh::owners))
      .def_property_readonly("containing_dimensions", Column(&SharedMesh::containing_dimensions))
      .def_property_readonly("cells", Column(&SharedMesh::cells, corners))
      .def_property_readonly("neighbours", Column(&SharedMesh::neighbours, corners))
      .def_property_readonly("regions", Column(&SharedMesh::regions))
      .def_property_readonly("subsegments", Column(&SharedMesh::subsegments, fixed(2)))
      .def_property_readonly("subsegment_owners", Column(&SharedMesh::subsegment_owners))
      .def_property_readonly("subfacets", Column(&SharedMesh::subfacets, fixed(3)))
      .def_property_readonly("subfacet_owners", Column(&SharedMesh::subfacet_owners))
      .def_property_readonly("region_sets", &RegionSets)
      .def_property_readonly("labels",
                             [](SharedMesh& m) {
                               const auto labels = [&m] {
                                 const PatientLock lock(m.mutex());
                                 return m.replica().labels();
                               }();
                               return LabelTuples(labels);
                             })
      .def("compact", &CompactDict)
      .def(
          "write",
          [](SharedMesh& m, const py::dict& options, const std::string& path,
             const py::dict& choices) {
            const Mesh whole = [&m] {
              const PatientLock lock(m.mutex());
              return m.replica().ToMesh();
            }();
            Write(whole, options, path, choices, /*is_part=*/false);
          },
          py::arg("options"), py::arg("path"), py::arg("choices"))
      .def("patch", &PatchDict)
      .def("find", &Find)
      .def("find_cells", &FindCells);
  BindEditing(mesh);
}

}  // namespace dynmesh::python
