// Batches from columns.
#include <pybind11/stl.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <set>
#include <vector>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "core/base/feature_kinds.h"

namespace dynmesh::python {
namespace {

// Each has a function of a batch, here and in the package.
static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);

using Ids = InArray<std::uint64_t>;
using Doubles = InArray<double>;

std::size_t RowsOf(const Ids& ids, const Doubles& positions, int dimension) {
  const auto n = static_cast<std::size_t>(ids.size());
  Require(ids.ndim() == 1, "ids must be a one-dimensional array");
  Require(positions.ndim() == 2 && static_cast<std::size_t>(positions.shape(0)) == n &&
              positions.shape(1) == dimension,
          "there must be one place of " + std::to_string(dimension) + " coordinates for each id");
  return n;
}

std::array<double, 3> PositionOf(const Doubles& positions, std::size_t row, int dimension) {
  std::array<double, 3> position = {0, 0, 0};
  for (int k = 0; k < dimension; ++k) {
    position[static_cast<std::size_t>(k)] =
        positions.data()[row * static_cast<std::size_t>(dimension) + static_cast<std::size_t>(k)];
  }
  return position;
}

Edit EditOf(const std::string& action, const Feature& feature) {
  if (action == "add") return Edit::Add(feature);
  if (action == "set") return Edit::Set(feature);
  throw py::value_error("an action is add or set");
}

void Points(Batch& batch, const std::string& action, const Ids& ids, const Doubles& positions) {
  const std::size_t n = RowsOf(ids, positions, batch.dimension);
  for (std::size_t i = 0; i < n; ++i) {
    const auto p = PositionOf(positions, i, batch.dimension);
    batch.edits.push_back(EditOf(action, Feature::Point(ids.data()[i], p[0], p[1], p[2])));
  }
}

void Moves(Batch& batch, const Ids& ids, const Doubles& positions) {
  const std::size_t n = RowsOf(ids, positions, batch.dimension);
  for (std::size_t i = 0; i < n; ++i) {
    const auto p = PositionOf(positions, i, batch.dimension);
    batch.edits.push_back(Edit::Move(ids.data()[i], p[0], p[1], p[2]));
  }
}

void Segments(Batch& batch, const std::string& action, const Ids& ids, const Ids& ends) {
  const auto n = static_cast<std::size_t>(ids.size());
  Require(ends.ndim() == 2 && static_cast<std::size_t>(ends.shape(0)) == n && ends.shape(1) == 2,
          "there must be two ends, ids of points, for each id");
  for (std::size_t i = 0; i < n; ++i) {
    batch.edits.push_back(EditOf(
        action, Feature::Segment(ids.data()[i], ends.data()[2 * i], ends.data()[2 * i + 1])));
  }
}

void Polygon(Batch& batch, const std::string& action, FeatureId id, const Rings& rings) {
  batch.edits.push_back(EditOf(action, Feature::Polygon(id, rings)));
}

void Size(Batch& batch, const std::string& action, FeatureId id, const py::dict& size) {
  const auto number = [&](const char* key) { return py::cast<double>(size[key]); };
  const auto position_of = [&](const py::handle& value, const char* key) {
    const auto values = py::cast<std::vector<double>>(value);
    Require(values.size() == static_cast<std::size_t>(batch.dimension),
            std::string(key) + " must have " + std::to_string(batch.dimension) + " coordinates");
    std::array<double, 3> result = {0, 0, 0};
    std::copy(values.begin(), values.end(), result.begin());
    return result;
  };
  const auto position = [&](const char* key) { return position_of(size[key], key); };
  Require(size.contains("target"), "a size must have a target");
  Sizing sizing;
  sizing.target = number("target");
  Feature feature;
  if (size.contains("rings")) {
    feature = Feature::SizePolygon(id, py::cast<Rings>(size["rings"]), sizing.target);
  } else if (size.contains("path")) {
    Require(size.contains("radius"), "a size with a `path` must have a `radius`");
    Path path;
    for (const py::handle vertex : size["path"]) path.push_back(position_of(vertex, "path"));
    feature = Feature::SizeCapsule(id, std::move(path), number("radius"), sizing.target);
  } else if (size.contains("low")) {
    sizing.shape = SizeShape::kBox;
    sizing.hi = position("high");
    feature = Feature::Size(id, position("low"), sizing);
  } else {
    Require(size.contains("at"), "a size must have `at`, `low` and `high`, `rings` or `path`");
    if (size.contains("radius")) {
      sizing.shape = SizeShape::kDisc;
      sizing.radius = number("radius");
    }
    feature = Feature::Size(id, position("at"), sizing);
  }
  batch.edits.push_back(EditOf(action, feature));
}

// Marks what the batch adds or sets as unsplit: the segments and polygons with these ids, or all.
// Returns the ids that it neither adds nor sets as such.
std::vector<FeatureId> Unsplit(Batch& batch, const std::optional<std::vector<FeatureId>>& ids) {
  std::set<FeatureId> wanted;
  if (ids) wanted = {ids->begin(), ids->end()};
  std::set<FeatureId> found;
  for (Edit& edit : batch.edits) {
    const bool is_new = edit.action == Edit::Action::kAdd || edit.action == Edit::Action::kSet;
    if (!is_new || !Is<ASegment, APolygon>(edit.feature, Not<APoint, ASize>)) continue;
    if (ids && !wanted.contains(edit.feature.id)) continue;
    edit.feature.unsplit = true;
    found.insert(edit.feature.id);
  }
  std::vector<FeatureId> missing;
  std::ranges::set_difference(wanted, found, std::back_inserter(missing));
  return missing;
}

void Remove(Batch& batch, const Ids& ids) {
  for (const std::uint64_t id : SpanOf(ids)) batch.edits.push_back(Edit::Remove(id));
}

void SetLabel(Batch& batch, FeatureId id, std::int64_t marker, const std::string& name) {
  batch.edits.push_back(Edit::SetLabel(id, {marker, name}));
}

}  // namespace

void BindEdits(py::module_& module) {
  py::class_<Batch>(module, "Batch")
      .def(py::init([](int dimension) {
             return Batch{{}, dimension};
           }),
           py::arg("dimension"))
      .def_property_readonly("dimension", [](const Batch& batch) { return batch.dimension; })
      .def("__len__", [](const Batch& batch) { return batch.edits.size(); })
      .def("points", &Points)
      .def("moves", &Moves)
      .def("segments", &Segments)
      .def("polygon", &Polygon)
      .def("size", &Size)
      .def("unsplit", &Unsplit, py::arg("ids"))
      .def("remove", &Remove)
      .def("label", &SetLabel);
  module.attr("last_feature_id") = py::int_(kLastFeatureId);
  module.def("known_options", [] {
    return std::vector<std::string>{"dimension", "box",      "kind",         "rho",
                                    "criterion", "max_edge", "min_dihedral", "max_vertices"};
  });
}

}  // namespace dynmesh::python
