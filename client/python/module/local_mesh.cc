// A mesh in this process: the library without a server.
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/progress_call.h"
#include "client/python/module/status.h"

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

class LocalMesh {
 public:
  explicit LocalMesh(const MeshOptions& options) : mesh_(Value(DynamicMesh::Create(options))) {}

  std::shared_ptr<Diff> Apply(const Batch& batch, const py::object& progress, bool validate_only) {
    ApplyOptions options;
    ProgressCall call(progress);
    options.interrupted = [cancelled = call.cancelled()] {
      return cancelled->load(std::memory_order_relaxed);
    };
    options.progress = [&](const ApplyProgress& p) { call(NameOf(p.stage), p.done, p.total); };
    absl::StatusOr<MeshDiff> diff = absl::UnknownError("");
    {
      py::gil_scoped_release release;
      if (validate_only) {
        absl::Status status = mesh_->Validate(batch.edits);
        MeshDiff none;
        none.dimension = mesh_->options().dimension;
        none.from_revision = none.to_revision = mesh_->revision(), none.hash = mesh_->hash();
        diff = status.ok() ? absl::StatusOr<MeshDiff>(none) : absl::StatusOr<MeshDiff>(status);
      } else {
        diff = mesh_->Apply(batch.edits, options);
      }
    }
    call.RaiseIf(!diff.ok());
    return std::make_shared<Diff>(Diff{Value(std::move(diff)), false});
  }
  std::shared_ptr<Mesh> Snapshot() const {
    py::gil_scoped_release release;
    return std::make_shared<Mesh>(mesh_->Snapshot());
  }
  py::list Features() const { return FeatureDicts(mesh_->Features(), mesh_->options().dimension); }
  py::array Locate(const InArray<double>& points) const {
    SimplexColumn ids = mesh_->Locate(SpanOf(points));
    return Take(std::move(ids), static_cast<std::size_t>(mesh_->options().dimension + 1));
  }
  std::uint64_t Revision() const { return mesh_->revision(); }
  py::dict Options() const { return OptionsDict(mesh_->options()); }
  py::list Audit() const {
    py::gil_scoped_release release;
    const AuditReport report = mesh_->Audit();
    py::gil_scoped_acquire acquire;
    return py::cast(report.problems);
  }

 private:
  std::unique_ptr<DynamicMesh> mesh_;
};

}  // namespace

void BindLocalMesh(py::module_& module) {
  py::class_<LocalMesh>(module, "LocalMesh")
      .def(py::init([](const py::dict& options) { return LocalMesh(OptionsOf(options)); }))
      .def("apply", &LocalMesh::Apply, py::arg("batch"), py::arg("progress") = py::none(),
           py::arg("validate_only") = false)
      .def("snapshot", &LocalMesh::Snapshot)
      .def("features", &LocalMesh::Features)
      .def("locate", &LocalMesh::Locate)
      .def("revision", &LocalMesh::Revision)
      .def("options", &LocalMesh::Options)
      .def("audit", &LocalMesh::Audit);
}

}  // namespace dynmesh::python
