// Transfer of arrays, in place.
#include "dynmesh/transfer.h"

#include <pybind11/stl.h>

#include <string>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
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
  if (name == "overlap") return FieldKind::kLargestOverlap;
  throw py::value_error("there is no kind " + name + "; there are P0, P1, DG1, overlap");
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

}  // namespace

void BindTransfer(py::module_& module) {
  py::class_<Transfer>(module, "Transfer")
      .def(py::init([](const SlotMesh& mesh) {
             py::gil_scoped_release release;
             return Value(Transfer::Make(mesh));
           }),
           py::keep_alive<1, 2>())
      .def(
          "carry",
          [](Transfer& transfer, Field field, std::size_t size, const std::string& kind,
             int components, int rings, bool bounded) {
            const FieldOptions options = {KindOf(kind), components, rings, bounded};
            const auto values = SpanOfField(field, size);
            return FlowList([&] {
              py::gil_scoped_release release;
              return Value(transfer.Carry(options, values));
            }());
          },
          py::arg("field").noconvert(), py::arg("size"), py::arg("kind"), py::arg("components"),
          py::arg("rings"), py::arg("bounded"))
      .def(
          "carry_momentum",
          [](Transfer& transfer, Field density, std::size_t density_size, Field velocity,
             std::size_t size, const std::string& kind, int components, int rings, bool bounded) {
            const FieldOptions options = {KindOf(kind), components, rings, bounded};
            const auto densities = SpanOfField(density, density_size);
            const auto values = SpanOfField(velocity, size);
            return FlowList([&] {
              py::gil_scoped_release release;
              return Value(transfer.CarryMomentum(options, densities, values));
            }());
          },
          py::arg("density").noconvert(), py::arg("density_size"), py::arg("velocity").noconvert(),
          py::arg("size"), py::arg("kind"), py::arg("components"), py::arg("rings"),
          py::arg("bounded"))
      .def("donors", [](const Transfer& transfer) { return Take(transfer.Donors()); })
      .def("pieces", [](const Transfer& transfer) {
        std::vector<Slot> from, to;
        std::vector<double> measures;
        for (const OverlapPiece& piece : transfer.Pieces()) {
          from.push_back(piece.from), to.push_back(piece.to), measures.push_back(piece.measure);
        }
        return py::make_tuple(Take(std::move(from)), Take(std::move(to)),
                              Take(std::move(measures)));
      });
}

}  // namespace dynmesh::python
