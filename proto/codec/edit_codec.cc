#include "proto/codec/edit_codec.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::codec {
namespace {

absl::Status EditError(std::size_t index, FeatureId id, const char* reason_text,
                       absl::string_view what) {
  ErrorDetail detail;
  detail.reason = reason_text;
  if (id != kNoFeature) detail.features.push_back(id);
  detail.edit = index;
  return MakeError(absl::StatusCode::kInvalidArgument,
                   absl::StrCat("edit ", index, " (feature ", id, "): ", what), std::move(detail));
}

absl::Status OptionError(absl::string_view field, absl::string_view message) {
  ServiceError error;
  error.reason = dynmesh::reason::kBadOption;
  error.field = absl::StrCat("options.", field);
  return MakeServiceError(absl::StatusCode::kInvalidArgument,
                          absl::StrCat("options.", field, ": ", message), error);
}

// Converts an error of ValidateOptions, which begins with the member's name, to the field's path in
// the message: the members of `limits` are direct fields there.
absl::Status OnWire(const absl::Status& status) {
  const absl::string_view message = status.message();
  const std::size_t colon = message.find(": ");
  if (colon == absl::string_view::npos) return status;
  return OptionError(absl::StripPrefix(message.substr(0, colon), "limits."),
                     message.substr(colon + 2));
}

absl::Status DecodePoint(const v1::Point& proto, int dimension, std::size_t index, FeatureId id,
                         std::array<double, 3>* out) {
  if (proto.has_z() != (dimension == 3)) {
    return EditError(index, id, reason::kWrongDimension,
                     dimension == 3 ? "the mesh is three-dimensional: set z"
                                    : "the mesh is planar: leave z unset");
  }
  *out = {proto.x(), proto.y(), dimension == 3 ? proto.z() : 0.0};
  return absl::OkStatus();
}

Rings DecodeRings(const v1::Polygon& proto) {
  Rings rings;
  rings.reserve(static_cast<std::size_t>(proto.rings_size()));
  for (const v1::Polygon::Ring& ring : proto.rings()) {
    rings.emplace_back(ring.points().begin(), ring.points().end());
  }
  return rings;
}

absl::Status DecodeSizing(const v1::Sizing& proto, int dimension, std::size_t index, FeatureId id,
                          Feature* out) {
  const auto point = [&](const v1::Point& p, std::array<double, 3>* to) {
    return DecodePoint(p, dimension, index, id, to);
  };
  out->sizing.target = proto.target();
  switch (proto.region_case()) {
    case v1::Sizing::kPoint:
      out->sizing.shape = SizeShape::kPoint;
      return point(proto.point(), &out->position);
    case v1::Sizing::kDisc:
      out->sizing.shape = SizeShape::kDisc;
      out->sizing.radius = proto.disc().radius();
      return point(proto.disc().centre(), &out->position);
    case v1::Sizing::kBox:
      out->sizing.shape = SizeShape::kBox;
      if (absl::Status s = point(proto.box().lo(), &out->position); !s.ok()) return s;
      return point(proto.box().hi(), &out->sizing.hi);
    case v1::Sizing::kPolygon:
      out->sizing.shape = SizeShape::kPolygon;
      out->rings = DecodeRings(proto.polygon());
      return absl::OkStatus();
    case v1::Sizing::kCapsule:
      out->sizing.shape = SizeShape::kCapsule;
      out->sizing.radius = proto.capsule().radius();
      out->sizing.path.reserve(static_cast<std::size_t>(proto.capsule().vertices_size()));
      for (const v1::Point& vertex : proto.capsule().vertices()) {
        if (absl::Status s = point(vertex, &out->sizing.path.emplace_back()); !s.ok()) return s;
      }
      return absl::OkStatus();
    case v1::Sizing::REGION_NOT_SET:
      break;
  }
  return EditError(index, id, dynmesh::reason::kBadSize,
                   "it has no region that this server knows: set point, disc, box, polygon or "
                   "capsule");
}

OptionalLabel DecodeLabel(const v1::FeatureLabel& proto) { return {proto.marker(), proto.name()}; }

absl::Status DecodeFeature(const v1::Feature& proto, int dimension, std::size_t index,
                           Feature* out) {
  out->id = proto.id();
  if (proto.has_label()) out->label = DecodeLabel(proto.label());
  out->unsplit = proto.unsplit();
  if (out->unsplit && (proto.has_point() || proto.has_size())) {
    return EditError(index, proto.id(), dynmesh::reason::kWrongKind,
                     "only segments and polygons can be unsplit");
  }
  switch (proto.geometry_case()) {
    case v1::Feature::kPoint:
      out->kind = FeatureKind::kPoint;
      return DecodePoint(proto.point(), dimension, index, proto.id(), &out->position);
    case v1::Feature::kSegment:
      out->kind = FeatureKind::kSegment;
      out->ends = {proto.segment().p(), proto.segment().q()};
      return absl::OkStatus();
    case v1::Feature::kPolygon:
      out->kind = FeatureKind::kPolygon;
      out->rings = DecodeRings(proto.polygon());
      return absl::OkStatus();
    case v1::Feature::kSize:
      out->kind = FeatureKind::kSize;
      return DecodeSizing(proto.size(), dimension, index, proto.id(), out);
    case v1::Feature::GEOMETRY_NOT_SET:
      break;
  }
  return EditError(
      index, proto.id(), dynmesh::reason::kWrongKind,
      "it has no geometry that this server knows: set point, segment, polygon or size");
}

absl::Status DecodeEdit(const v1::Edit& proto, int dimension, std::size_t index, Edit* out) {
  switch (proto.action_case()) {
    case v1::Edit::kAdd:
      out->action = Edit::Action::kAdd;
      return DecodeFeature(proto.add(), dimension, index, &out->feature);
    case v1::Edit::kSet:
      out->action = Edit::Action::kSet;
      return DecodeFeature(proto.set(), dimension, index, &out->feature);
    case v1::Edit::kRemove:
      *out = Edit::Remove(proto.remove());
      return absl::OkStatus();
    case v1::Edit::kMove:
      *out = Edit::Move(proto.move().id(), 0, 0);
      return DecodePoint(proto.move().to(), dimension, index, proto.move().id(),
                         &out->feature.position);
    case v1::Edit::kSetLabel:
      out->action = Edit::Action::kSetLabel;
      out->feature.id = proto.set_label().id();
      out->feature.label = DecodeLabel(proto.set_label().label());
      return absl::OkStatus();
    case v1::Edit::ACTION_NOT_SET:
      break;
  }
  return EditError(index, kNoFeature, reason::kBadRequest,
                   "it has no action that this server knows: set add, set, remove, move or "
                   "set_label");
}

void EncodeLabel(const FeatureLabel& label, v1::FeatureLabel* out) {
  out->set_marker(label.marker);
  out->set_name(label.name);
}

void EncodePoint(const std::array<double, 3>& position, int dimension, v1::Point* out) {
  out->set_x(position[0]);
  out->set_y(position[1]);
  if (dimension == 3) out->set_z(position[2]);
}

void EncodeRings(const Rings& rings, v1::Polygon* out) {
  for (const std::vector<FeatureId>& ring : rings) {
    out->add_rings()->mutable_points()->Add(ring.begin(), ring.end());
  }
}

void EncodeSizing(const Feature& feature, int dimension, v1::Sizing* out) {
  const Sizing& sizing = feature.sizing;
  out->set_target(sizing.target);
  switch (sizing.shape) {
    case SizeShape::kPoint:
      return EncodePoint(feature.position, dimension, out->mutable_point());
    case SizeShape::kDisc:
      out->mutable_disc()->set_radius(sizing.radius);
      return EncodePoint(feature.position, dimension, out->mutable_disc()->mutable_centre());
    case SizeShape::kBox:
      EncodePoint(feature.position, dimension, out->mutable_box()->mutable_lo());
      return EncodePoint(sizing.hi, dimension, out->mutable_box()->mutable_hi());
    case SizeShape::kPolygon:
      return EncodeRings(feature.rings, out->mutable_polygon());
    case SizeShape::kCapsule:
      out->mutable_capsule()->set_radius(sizing.radius);
      for (const auto& vertex : sizing.path) {
        EncodePoint(vertex, dimension, out->mutable_capsule()->add_vertices());
      }
      return;
  }
}

// Entries past the dimension keep their defaults, so that equal options compare equal.
void DecodeCorner(const v1::Point& p, std::array<double, 3>* out) {
  (*out)[0] = p.x();
  (*out)[1] = p.y();
  if (p.has_z()) (*out)[2] = p.z();
}

}  // namespace

absl::StatusOr<MeshOptions> DecodeOptions(const v1::MeshOptions& proto,
                                          std::uint64_t max_vertices) {
  MeshOptions options;
  if (proto.dimension() != 0) options.dimension = proto.dimension();
  if (!proto.has_box()) return OptionError("box", "is missing: say where features may lie");
  for (const v1::Point* corner : {&proto.box().lo(), &proto.box().hi()}) {
    if (corner->has_z() != (options.dimension == 3)) {
      return OptionError(
          "box", options.dimension == 3 ? "its corners need a z" : "its corners have a z in 2D");
    }
  }
  DecodeCorner(proto.box().lo(), &options.box.lo);
  DecodeCorner(proto.box().hi(), &options.box.hi);
  options.quality = proto.quality() != 0 ? proto.quality() : DefaultQuality(options.dimension);
  switch (proto.criterion()) {
    case v1::CRITERION_UNSPECIFIED:
    case v1::CRITERION_EDGE:
      options.criterion = Criterion::kEdge;
      break;
    case v1::CRITERION_THESIS:
      options.criterion = Criterion::kThesis;
      break;
    default:
      return OptionError("criterion", "is unknown: EDGE or THESIS");
  }
  switch (proto.kind()) {
    case v1::MESH_KIND_UNSPECIFIED:
    case v1::MESH_KIND_DELAUNAY:
      options.kind = MeshKind::kDelaunay;
      break;
    case v1::MESH_KIND_QUADTREE:
      options.kind = MeshKind::kQuadtree;
      break;
    case v1::MESH_KIND_TRIANGULATION:
      options.kind = MeshKind::kTriangulation;
      break;
    default:
      return OptionError("kind", "is unknown: DELAUNAY, QUADTREE or TRIANGULATION");
  }
  if (proto.max_vertices() > max_vertices) {
    return OptionError("max_vertices", absl::StrCat("is above this server's ", max_vertices));
  }
  const std::uint64_t most = MostVertices(options.dimension);
  options.limits.max_vertices =
      proto.max_vertices() != 0 ? proto.max_vertices() : std::min(max_vertices, most);
  // From a journal or a server's answer. Limits were once unrestricted, and no mesh has come near
  // this one.
  if (max_vertices == std::numeric_limits<std::uint64_t>::max()) {
    options.limits.max_vertices = std::min(options.limits.max_vertices, most);
  }
  if (proto.max_depth() != 0) options.limits.max_depth = proto.max_depth();
  options.max_edge = proto.max_edge();
  options.min_dihedral = proto.has_min_dihedral()
                             ? proto.min_dihedral()
                             : DefaultMinDihedral(options.dimension, options.kind);
  if (absl::Status status = ValidateOptions(options); !status.ok()) return OnWire(status);
  return options;
}

void EncodeOptions(const MeshOptions& options, v1::MeshOptions* out) {
  out->set_dimension(options.dimension);
  EncodePoint(options.box.lo, options.dimension, out->mutable_box()->mutable_lo());
  EncodePoint(options.box.hi, options.dimension, out->mutable_box()->mutable_hi());
  out->set_quality(options.quality);
  out->set_criterion(options.criterion == Criterion::kThesis ? v1::CRITERION_THESIS
                                                             : v1::CRITERION_EDGE);
  out->set_max_vertices(options.limits.max_vertices);
  out->set_max_depth(options.limits.max_depth);
  out->set_max_edge(options.max_edge);
  out->set_min_dihedral(options.min_dihedral);
  switch (options.kind) {
    case MeshKind::kDelaunay:
      return out->set_kind(v1::MESH_KIND_DELAUNAY);
    case MeshKind::kQuadtree:
      return out->set_kind(v1::MESH_KIND_QUADTREE);
    case MeshKind::kTriangulation:
      return out->set_kind(v1::MESH_KIND_TRIANGULATION);
  }
}

absl::Status DecodeEdits(const google::protobuf::RepeatedPtrField<v1::Edit>& proto, int dimension,
                         EditBatch* out) {
  for (const v1::Edit& p : proto) {
    const std::size_t index = out->size();
    if (absl::Status s = DecodeEdit(p, dimension, index, &out->emplace_back()); !s.ok()) return s;
  }
  return absl::OkStatus();
}

absl::Status DecodePointColumns(const v1::PointColumns& proto, int dimension, EditBatch* out) {
  const auto rows = static_cast<std::int64_t>(proto.ids_size());
  const auto numbers = static_cast<std::int64_t>(proto.coordinates_size());
  if (numbers != rows * dimension) {
    ServiceError error;
    error.reason =
        numbers == rows * (5 - dimension) ? reason::kWrongDimension : reason::kBadRequest;
    error.field = "points.coordinates";
    return MakeServiceError(absl::StatusCode::kInvalidArgument,
                            absl::StrCat("points.coordinates: there are ", numbers, " for ", rows,
                                         " points, ", dimension, " are wanted for each"),
                            error);
  }
  const double* x = proto.coordinates().data();
  for (const FeatureId id : proto.ids()) {
    out->push_back(Edit::Add(Feature::Point(id, x[0], x[1], dimension == 3 ? x[2] : 0)));
    x += dimension;
  }
  return absl::OkStatus();
}

void EncodePointRow(const Feature& point, int dimension, v1::PointColumns* out) {
  out->add_ids(point.id);
  for (int k = 0; k < dimension; ++k) {
    out->add_coordinates(point.position[static_cast<std::size_t>(k)]);
  }
}

absl::Status DecodeAdds(const google::protobuf::RepeatedPtrField<v1::Feature>& proto, int dimension,
                        EditBatch* out) {
  for (const v1::Feature& p : proto) {
    const std::size_t index = out->size();
    Edit& edit = out->emplace_back();
    if (absl::Status s = DecodeFeature(p, dimension, index, &edit.feature); !s.ok()) return s;
  }
  return absl::OkStatus();
}

namespace {

// A ring without points takes as much memory as three points.
constexpr std::size_t kPointsOfRing = sizeof(Rings::value_type) / sizeof(FeatureId);
constexpr std::size_t kPointsOfVertex = sizeof(Path::value_type) / sizeof(FeatureId);

std::size_t Points(const v1::Polygon& polygon) {
  std::size_t points = 0;
  for (const v1::Polygon::Ring& ring : polygon.rings()) {
    points += kPointsOfRing + static_cast<std::size_t>(ring.points_size());
  }
  return points;
}

std::size_t PointsOfLabel(std::size_t name_bytes) {
  return (sizeof(FeatureLabel) + name_bytes) / sizeof(FeatureId);
}

std::size_t PointsOfShape(const v1::Feature& feature) {
  if (feature.has_polygon()) return Points(feature.polygon());
  if (feature.size().has_capsule()) {
    return kPointsOfVertex * static_cast<std::size_t>(feature.size().capsule().vertices_size());
  }
  return feature.size().has_polygon() ? Points(feature.size().polygon()) : 0;
}

std::size_t Points(const v1::Feature& feature) {
  const std::size_t points = PointsOfShape(feature);
  return feature.has_label() ? points + PointsOfLabel(feature.label().name().size()) : points;
}

std::size_t Points(const v1::Edit& edit) {
  if (edit.has_set_label()) return PointsOfLabel(edit.set_label().label().name().size());
  return edit.has_set() ? Points(edit.set()) : Points(edit.add());
}

std::size_t Points(const Edit& edit) {
  std::size_t points = kPointsOfVertex * edit.feature.sizing.path.size();
  if (edit.feature.label) points += PointsOfLabel(edit.feature.label->name.size());
  for (const auto& ring : edit.feature.rings) points += kPointsOfRing + ring.size();
  return points;
}

template <typename Items>
std::size_t WeightOf(const Items& items) {
  constexpr std::size_t kPointsOfOne = 8;  // bytes of an edit without a polygon
  std::size_t points = 0;
  for (const auto& item : items) points += Points(item);
  return static_cast<std::size_t>(items.size()) + points / kPointsOfOne;
}

}  // namespace

std::size_t Weight(const google::protobuf::RepeatedPtrField<v1::Edit>& proto) {
  return WeightOf(proto);
}

std::size_t Weight(const google::protobuf::RepeatedPtrField<v1::Feature>& proto) {
  return WeightOf(proto);
}

std::size_t Weight(const EditBatch& edits) { return WeightOf(edits); }

void EncodeFeature(const Feature& feature, int dimension, v1::Feature* out) {
  out->set_id(feature.id);
  if (feature.label) EncodeLabel(*feature.label, out->mutable_label());
  switch (feature.kind) {
    case FeatureKind::kPoint:
      EncodePoint(feature.position, dimension, out->mutable_point());
      break;
    case FeatureKind::kSegment:
      out->mutable_segment()->set_p(feature.ends[0]);
      out->mutable_segment()->set_q(feature.ends[1]);
      out->set_unsplit(feature.unsplit);
      break;
    case FeatureKind::kPolygon:
      EncodeRings(feature.rings, out->mutable_polygon());
      out->set_unsplit(feature.unsplit);
      break;
    case FeatureKind::kSize:
      EncodeSizing(feature, dimension, out->mutable_size());
      break;
  }
}

void EncodeEdit(const Edit& edit, int dimension, v1::Edit* out) {
  switch (edit.action) {
    case Edit::Action::kAdd:
      EncodeFeature(edit.feature, dimension, out->mutable_add());
      break;
    case Edit::Action::kSet:
      EncodeFeature(edit.feature, dimension, out->mutable_set());
      break;
    case Edit::Action::kRemove:
      out->set_remove(edit.feature.id);
      break;
    case Edit::Action::kMove:
      out->mutable_move()->set_id(edit.feature.id);
      EncodePoint(edit.feature.position, dimension, out->mutable_move()->mutable_to());
      break;
    case Edit::Action::kSetLabel:
      out->mutable_set_label()->set_id(edit.feature.id);
      if (!edit.feature.label) break;
      EncodeLabel(*edit.feature.label, out->mutable_set_label()->mutable_label());
      break;
  }
}

}  // namespace dynmesh::codec
