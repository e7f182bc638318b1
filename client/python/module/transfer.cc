// Transfer of arrays, in place.
#include "dynmesh/transfer.h"

#include <pybind11/stl.h>

#include <optional>
#include <string>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "client/python/module/shared_mesh.h"
#include "client/python/module/status.h"

namespace dynmesh::python {
namespace {

// Written in place, so never converted.
using Field = py::array_t<double, py::array::c_style>;

FieldKind KindOf(const std::string& name) {
  if (name == "P0") return FieldKind::kP0;
  if (name == "P0-linear") return FieldKind::kP0Linear;
  if (name == "P1") return FieldKind::kP1;
  if (name == "DG1") return FieldKind::kDG1;
  if (name == "dual") return FieldKind::kDual;
  if (name == "dual-corners") return FieldKind::kDualCorners;
  if (name == "overlap") return FieldKind::kLargestOverlap;
  throw py::value_error("there is no kind " + name + "; there are P0, P1, DG1, dual, overlap");
}

// The first `size` numbers.
std::span<double> SpanOfField(Field& field, std::size_t size) {
  Require(
      static_cast<std::size_t>(field.size()) >= size,
      "the field has " + std::to_string(field.size()) + " numbers, not " + std::to_string(size));
  return {field.mutable_data(), size};
}

py::list FlowList(const std::vector<RegionFlow>& flows) {
  py::list result;
  for (const RegionFlow& flow : flows) {
    result.append(py::make_tuple(flow.from, flow.to, py::cast(flow.amounts)));
  }
  return result;
}

// The transfer for one patch of a shared mesh, used under the mesh's lock.
class SharedTransfer {
 public:
  // FAILED_PRECONDITION if the last patch is not that from `from_revision` to `to_revision`.
  SharedTransfer(SharedMesh& mesh, std::uint64_t from_revision, std::uint64_t to_revision)
      : mesh_(mesh) {
    py::gil_scoped_release release;
    const MutexLock lock(mesh_.mutex());
    const MeshPatch& patch = mesh_.replica().patch();
    if (patch.from_revision != from_revision || patch.to_revision != to_revision) {
      throw StatusError(absl::FailedPreconditionError("the mesh has a later patch"));
    }
    transfer_.emplace(Value(Transfer::Make(mesh_.replica())));
  }

  // Calls f(transfer) without the GIL. FAILED_PRECONDITION if the mesh has changed since.
  template <class F>
  auto Use(F f) {
    py::gil_scoped_release release;
    const MutexLock lock(mesh_.mutex());
    return f(*transfer_);
  }

 private:
  SharedMesh& mesh_;
  std::optional<Transfer> transfer_;
};

py::list Carry(SharedTransfer& transfer, Field field, std::size_t size, const std::string& kind,
               int components, int rings, bool bounded) {
  const FieldOptions options = {KindOf(kind), components, rings, bounded};
  const auto values = SpanOfField(field, size);
  return FlowList(transfer.Use([&](Transfer& t) { return Value(t.Carry(options, values)); }));
}

py::list CarryMomentum(SharedTransfer& transfer, Field density, std::size_t density_size,
                       Field velocity, std::size_t size, const std::string& kind, int components,
                       int rings, bool bounded) {
  const FieldOptions options = {KindOf(kind), components, rings, bounded};
  const auto densities = SpanOfField(density, density_size);
  const auto values = SpanOfField(velocity, size);
  return FlowList(transfer.Use(
      [&](Transfer& t) { return Value(t.CarryMomentum(options, densities, values)); }));
}

py::tuple Pieces(SharedTransfer& transfer) {
  std::vector<Slot> from, to;
  std::vector<double> measures;
  for (const OverlapPiece& piece : transfer.Use([](Transfer& t) { return t.Pieces(); })) {
    from.push_back(piece.from), to.push_back(piece.to), measures.push_back(piece.measure);
  }
  return py::make_tuple(Take(std::move(from)), Take(std::move(to)), Take(std::move(measures)));
}

}  // namespace

void BindTransfer(py::module_& module) {
  py::class_<SharedTransfer>(module, "Transfer")
      .def(py::init<SharedMesh&, std::uint64_t, std::uint64_t>(), py::arg("mesh"),
           py::arg("from_revision"), py::arg("to_revision"), py::keep_alive<1, 2>())
      .def("carry", &Carry, py::arg("field").noconvert(), py::arg("size"), py::arg("kind"),
           py::arg("components"), py::arg("rings"), py::arg("bounded"))
      .def("carry_momentum", &CarryMomentum, py::arg("density").noconvert(),
           py::arg("density_size"), py::arg("velocity").noconvert(), py::arg("size"),
           py::arg("kind"), py::arg("components"), py::arg("rings"), py::arg("bounded"))
      .def("donors",
           [](SharedTransfer& transfer) {
             return Take(transfer.Use([](Transfer& t) { return t.Donors(); }));
           })
      .def("pieces", &Pieces);
}

}  // namespace dynmesh::python
