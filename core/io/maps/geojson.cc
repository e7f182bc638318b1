#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/io/maps/json_fields.h"
#include "core/io/maps/line_work.h"
#include "core/io/maps/map_files.h"

namespace dynmesh::io {
namespace {

using text::Concat;
using text::Quoted;
using Index = JsonDocument::Index;
using Kind = JsonDocument::Kind;

// Recursion is as deep as the document, which is limited.
class GeoJsonReader {
 public:
  GeoJsonReader(const JsonDocument& json, bool polygons, MendedRings* mended)
      : json_(json), polygons_(polygons), mended_(mended) {}

  absl::StatusOr<FileFeatures> Read() {
    if (auto status = ReadObject(0); !status.ok()) return status;
    FileFeatures input = work_.Take(json_.name());
    input.heights = heights_;
    return input;
  }

 private:
  using Path = std::vector<LineWork::Node>;

  absl::Status ReadObject(Index v) {
    const absl::StatusOr<std::string_view> type = TypeOf(json_, v, "a GeoJSON object");
    if (!type.ok()) return type.status();
    if (*type == "FeatureCollection") {
      const auto features = Member(json_, v, "features", Kind::kArray, *type);
      if (!features.ok()) return features.status();
      return json_.ForEach(*features, [this](Index f) { return ReadFeature(f); });
    }
    if (*type == "Feature") return ReadFeature(v);
    return ReadGeometry(v);
  }

  absl::Status ReadFeature(Index v) {
    const absl::StatusOr<std::string_view> type = TypeOf(json_, v, "a feature");
    if (!type.ok()) return type.status();
    if (*type != "Feature") {
      return json_.Error(v, Concat("features must be of type Feature, found ", Quoted(*type)));
    }
    const std::optional<Index> geometry = json_.Find(v, "geometry");
    if (!geometry) return json_.Error(v, "a Feature has no member \"geometry\"; null is allowed");
    if (json_.kind(*geometry) == Kind::kNull) return absl::OkStatus();
    if (polygons_) names_ = NamesOf(json_, v);
    return ReadGeometry(*geometry);
  }

  absl::Status ReadGeometry(Index v) {
    const absl::StatusOr<std::string_view> type = TypeOf(json_, v, "a geometry");
    if (!type.ok()) return type.status();
    if (*type == "GeometryCollection") {
      const auto members = Member(json_, v, "geometries", Kind::kArray, *type);
      if (!members.ok()) return members.status();
      return json_.ForEach(*members, [this](Index g) { return ReadGeometry(g); });
    }
    // The nesting depth of arrays in a geometry's coordinates.
    constexpr struct {
      std::string_view type;
      int arrays;  // around what `read` takes
      absl::Status (GeoJsonReader::*read)(Index);
    } kGeometries[] = {
        {"Point", 0, &GeoJsonReader::ReadPoint},
        {"MultiPoint", 1, &GeoJsonReader::ReadPoint},
        {"LineString", 0, &GeoJsonReader::ReadLine},
        {"MultiLineString", 1, &GeoJsonReader::ReadLine},
        {"Polygon", 1, &GeoJsonReader::ReadRing},
        {"MultiPolygon", 2, &GeoJsonReader::ReadRing},
    };
    for (const auto& geometry : kGeometries) {
      if (*type != geometry.type) continue;
      const auto coordinates = Member(json_, v, "coordinates", Kind::kArray, *type);
      if (!coordinates.ok()) return coordinates.status();
      // Without coordinates it is an empty geometry (RFC 7946, section 3.1).
      if (json_.First(*coordinates) == json_.End(*coordinates)) return absl::OkStatus();
      absl::Status status = ReadNested(*coordinates, geometry.arrays, geometry.read);
      if (status.ok() && !rings_.empty()) {
        work_.AddPolygon(std::exchange(rings_, {}), names_, json_.line(v));
      }
      return status;
    }
    return json_.Error(v, Concat("unknown type ", Quoted(*type),
                                 ": expected FeatureCollection, Feature, Point, MultiPoint, "
                                 "LineString, MultiLineString, Polygon, MultiPolygon or "
                                 "GeometryCollection"));
  }

  absl::Status ReadNested(Index v, int arrays, absl::Status (GeoJsonReader::*read)(Index)) {
    if (arrays == 0) return (this->*read)(v);
    if (auto status = ExpectArray(json_, v, "a list of coordinates"); !status.ok()) return status;
    return json_.ForEach(v, [&](Index i) { return ReadNested(i, arrays - 1, read); });
  }

  absl::StatusOr<LineWork::Node> AddPosition(Index v) {
    const absl::StatusOr<Position> position = ReadPosition(json_, v);
    if (!position.ok()) return position.status();
    if (auto status = CheckMagnitude(json_, v, position->at); !status.ok()) return status;
    heights_ += position->has_more ? 1 : 0;
    return work_.Add(position->at, json_.line(v));
  }

  absl::Status ReadPoint(Index v) { return AddPosition(v).status(); }

  absl::Status ReadLine(Index v) { return ReadPath(v, "a line", 2, true).status(); }

  absl::Status ReadRing(Index v) {
    if (mended_ != nullptr) return MendRing(v);
    absl::StatusOr<Path> path = ReadPath(v, "a polygon's ring", 4, !polygons_);
    if (!path.ok()) return path.status();
    if (path->front() != path->back()) {
      return json_.Error(v, "a polygon's ring must end where it starts; repeat its first position");
    }
    if (polygons_) rings_.push_back(*std::move(path));
    return absl::OkStatus();
  }

  // A ring of one place is a point; one of two has no area, and is dropped with its positions; any
  // other is closed.
  absl::Status MendRing(Index v) {
    if (auto status = ExpectArray(json_, v, "a polygon's ring"); !status.ok()) return status;
    std::vector<std::pair<Index, std::array<double, 2>>> places;
    const absl::Status read = json_.ForEach(v, [&](Index i) {
      const absl::StatusOr<Position> position = ReadPosition(json_, i);
      if (!position.ok()) return position.status();
      if (places.empty() || places.back().second != position->at) {
        places.emplace_back(i, position->at);
      }
      return absl::OkStatus();
    });
    if (!read.ok()) return read;
    const bool is_closed = places.size() > 1 && places.front().second == places.back().second;
    const std::size_t count = places.size() - (is_closed ? 1 : 0);
    if (count == 0 || count == 2) {
      ++mended_->dropped;
      return absl::OkStatus();
    }
    Path path;
    for (std::size_t i = 0; i < count; ++i) {
      const absl::StatusOr<LineWork::Node> node = AddPosition(places[i].first);
      if (!node.ok()) return node.status();
      path.push_back(*node);
    }
    if (count == 1) {
      ++mended_->points;
      return absl::OkStatus();
    }
    if (!is_closed) ++mended_->closed;
    path.push_back(path.front());
    if (polygons_) {
      rings_.push_back(std::move(path));
      return absl::OkStatus();
    }
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      work_.Connect(path[i], path[i + 1], json_.line(places[(i + 1) % count].first));
    }
    return absl::OkStatus();
  }

  absl::StatusOr<Path> ReadPath(Index v, std::string_view what, std::size_t least, bool connect) {
    if (auto status = ExpectArray(json_, v, what); !status.ok()) return status;
    const std::size_t count = Count(json_, v);
    if (count < least) {
      return json_.Error(v, Concat(what, " needs ", least, " positions, found ", count));
    }
    Path path;
    path.reserve(count);
    const absl::Status status = json_.ForEach(v, [&](Index i) {
      const absl::StatusOr<LineWork::Node> node = AddPosition(i);
      if (!node.ok()) return node.status();
      if (connect && !path.empty()) work_.Connect(path.back(), *node, json_.line(i));
      path.push_back(*node);
      return absl::OkStatus();
    });
    if (!status.ok()) return status;
    return path;
  }

  const JsonDocument& json_;
  const bool polygons_;
  MendedRings* const mended_;  // null: nothing is mended
  LineWork work_;
  PolygonName names_;        // of the current feature
  std::vector<Path> rings_;  // of the current geometry, if it becomes a polygon
  std::uint64_t heights_ = 0;
};

}  // namespace

absl::StatusOr<FileFeatures> ReadGeoJson(const JsonDocument& json, bool polygons,
                                         MendedRings* mended) {
  return GeoJsonReader(json, polygons, mended).Read();
}

absl::StatusOr<FileFeatures> ReadMapFile(const std::string& path, const MapOptions& options) {
  const absl::StatusOr<JsonDocument> json = JsonDocument::Read(path, options.limits);
  if (!json.ok()) return json.status();
  const absl::StatusOr<std::string_view> type = TypeOf(*json, 0, "a map");
  if (!type.ok()) return type.status();
  return *type == "Topology" ? ReadTopoJson(*json, options.polygons)
                             : ReadGeoJson(*json, options.polygons, options.mended);
}

}  // namespace dynmesh::io
