// Features, labels and options as dicts and tuples. Both extension modules have these functions.
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "client/python/module/arrays.h"
#include "client/python/module/bind.h"
#include "core/base/feature_kinds.h"

namespace dynmesh::python {
namespace {

// Each has a dict in FeatureDicts.
static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);

py::tuple Tuple(const std::array<double, 3>& position, int dimension) {
  if (dimension == 2) return py::make_tuple(position[0], position[1]);
  return py::make_tuple(position[0], position[1], position[2]);
}

}  // namespace

py::list FeatureDicts(const std::vector<Feature>& features, int dimension) {
  py::list result;
  for (const Feature& f : features) {
    py::dict d;
    d["id"] = f.id;
    switch (f.kind) {
      case FeatureKind::kPoint:
        d["kind"] = "point", d["at"] = Tuple(f.position, dimension);
        break;
      case FeatureKind::kSegment:
        d["kind"] = "segment", d["ends"] = py::make_tuple(f.ends[0], f.ends[1]);
        break;
      case FeatureKind::kPolygon:
        d["kind"] = "polygon", d["rings"] = py::cast(f.rings);
        break;
      case FeatureKind::kSize:
        d["kind"] = "size", d["target"] = f.sizing.target;
        if (f.sizing.shape == SizeShape::kPolygon) {
          d["rings"] = py::cast(f.rings);
        } else if (f.sizing.shape == SizeShape::kCapsule) {
          py::list path;
          for (const auto& vertex : f.sizing.path) path.append(Tuple(vertex, dimension));
          d["path"] = path, d["radius"] = f.sizing.radius;
        } else if (f.sizing.shape == SizeShape::kBox) {
          d["low"] = Tuple(f.position, dimension), d["high"] = Tuple(f.sizing.hi, dimension);
        } else {
          d["at"] = Tuple(f.position, dimension);
          if (f.sizing.shape == SizeShape::kDisc) d["radius"] = f.sizing.radius;
        }
        break;
    }
    if (f.unsplit) d["unsplit"] = true;
    if (f.label) d["marker"] = f.label->marker, d["name"] = f.label->name;
    result.append(d);
  }
  return result;
}

py::list LabelTuples(const LabelColumn& labels) {
  py::list result;
  for (const auto& [id, label] : labels) {
    result.append(py::make_tuple(id, label.marker, label.name));
  }
  return result;
}

py::dict OptionsDict(const MeshOptions& options) {
  py::dict d;
  d["dimension"] = options.dimension;
  d["box"] = py::make_tuple(Tuple(options.box.lo, options.dimension),
                            Tuple(options.box.hi, options.dimension));
  d["kind"] = std::string(NameOf(options.kind));
  d["rho"] = options.quality;
  d["criterion"] = options.criterion == Criterion::kThesis ? "thesis" : "edge";
  d["max_edge"] = options.max_edge;
  d["min_dihedral"] = options.min_dihedral;
  d["max_vertices"] = options.limits.max_vertices;
  return d;
}

MeshOptions OptionsOf(const py::dict& options) {
  static const std::vector<std::string> known = {
      "dimension", "box", "kind", "rho", "criterion", "max_vertices", "max_edge", "min_dihedral"};
  for (const auto& [key, value] : options) {
    const auto name = py::cast<std::string>(key);
    Require(std::find(known.begin(), known.end(), name) != known.end(),
            "there is no option " + name +
                "; there are dimension, box, kind, rho, criterion, max_edge, min_dihedral, "
                "max_vertices");
  }
  MeshOptions result;
  if (options.contains("box")) {
    const auto box = py::cast<std::vector<std::vector<double>>>(options["box"]);
    Require(box.size() == 2 && box[0].size() == box[1].size() && box[0].size() >= 2 &&
                box[0].size() <= 3,
            "box must be two corners of 2 or 3 coordinates each");
    result.dimension = static_cast<int>(box[0].size());
    std::copy(box[0].begin(), box[0].end(), result.box.lo.begin());
    std::copy(box[1].begin(), box[1].end(), result.box.hi.begin());
  }
  if (options.contains("dimension")) {
    const int dimension = py::cast<int>(options["dimension"]);
    Require(!options.contains("box") || dimension == result.dimension,
            "dimension is not that of the box");
    result.dimension = dimension;
  }
  if (options.contains("kind")) {
    const auto name = py::cast<std::string>(options["kind"]);
    const absl::StatusOr<MeshKind> kind = MeshKindOf(name);
    Require(kind.ok(), std::string(kind.status().message()));
    result.kind = *kind;
  }
  result.quality =
      options.contains("rho") ? py::cast<double>(options["rho"]) : DefaultQuality(result.dimension);
  if (options.contains("criterion")) {
    const auto name = py::cast<std::string>(options["criterion"]);
    Require(name == "edge" || name == "thesis", "criterion must be edge or thesis");
    result.criterion = name == "edge" ? Criterion::kEdge : Criterion::kThesis;
  }
  if (options.contains("max_edge")) result.max_edge = py::cast<double>(options["max_edge"]);
  result.min_dihedral = options.contains("min_dihedral")
                            ? py::cast<double>(options["min_dihedral"])
                            : DefaultMinDihedral(result.dimension, result.kind);
  if (options.contains("max_vertices")) {
    result.limits.max_vertices = py::cast<std::uint64_t>(options["max_vertices"]);
  }
  return result;
}

}  // namespace dynmesh::python
