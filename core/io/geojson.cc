#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/data/text.h"
#include "core/io/json_fields.h"
#include "core/io/line_work.h"
#include "core/io/map_files.h"

namespace dynmesh::io {
namespace {

using data::Concat;
using data::Quoted;
using Index = JsonDocument::Index;
using Kind = JsonDocument::Kind;

// Recursion goes no deeper than the document does, which is limited.
class GeoJsonReader {
 public:
  explicit GeoJsonReader(const JsonDocument& json) : json_(json) {}

  absl::StatusOr<PlanarInput> Read() {
    if (auto status = ReadObject(0); !status.ok()) return status;
    PlanarInput input = work_.Take(json_.name());
    input.heights = heights_;
    return input;
  }

 private:
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
    // What a geometry is an array, of arrays, of ...
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
      // Without coordinates it is a geometry of nothing (RFC 7946, section 3.1).
      if (json_.First(*coordinates) == json_.End(*coordinates)) return absl::OkStatus();
      return ReadNested(*coordinates, geometry.arrays, geometry.read);
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

  absl::StatusOr<LineWork::Place> AddPosition(Index v) {
    const absl::StatusOr<Position> position = ReadPosition(json_, v);
    if (!position.ok()) return position.status();
    if (auto status = CheckMagnitude(json_, v, position->at); !status.ok()) return status;
    heights_ += position->has_more ? 1 : 0;
    return work_.Add(position->at, json_.line(v));
  }

  absl::Status ReadPoint(Index v) { return AddPosition(v).status(); }

  absl::Status ReadLine(Index v) { return ReadPath(v, "a line", 2).status(); }

  absl::Status ReadRing(Index v) {
    const auto ends = ReadPath(v, "a polygon's ring", 4);
    if (!ends.ok()) return ends.status();
    if (ends->first == ends->second) return absl::OkStatus();
    return json_.Error(v, "a polygon's ring must end where it starts; repeat its first position");
  }

  // The first and last place of the path.
  absl::StatusOr<std::pair<LineWork::Place, LineWork::Place>> ReadPath(Index v,
                                                                       std::string_view what,
                                                                       std::size_t least) {
    if (auto status = ExpectArray(json_, v, what); !status.ok()) return status;
    const std::size_t count = Count(json_, v);
    if (count < least) {
      return json_.Error(v, Concat(what, " needs ", least, " positions, found ", count));
    }
    std::optional<LineWork::Place> first;
    LineWork::Place last = 0;
    const absl::Status status = json_.ForEach(v, [&](Index i) {
      const absl::StatusOr<LineWork::Place> place = AddPosition(i);
      if (!place.ok()) return place.status();
      if (first) {
        work_.Connect(last, *place, json_.line(i));
      } else {
        first = *place;
      }
      last = *place;
      return absl::OkStatus();
    });
    if (!status.ok()) return status;
    return std::pair(*first, last);
  }

  const JsonDocument& json_;
  LineWork work_;
  std::uint64_t heights_ = 0;
};

}  // namespace

absl::StatusOr<PlanarInput> ReadGeoJson(const JsonDocument& json) {
  return GeoJsonReader(json).Read();
}

absl::StatusOr<PlanarInput> ReadMapFile(const std::string& path, const JsonLimits& limits) {
  const absl::StatusOr<JsonDocument> json = JsonDocument::Read(path, limits);
  if (!json.ok()) return json.status();
  const absl::StatusOr<std::string_view> type = TypeOf(*json, 0, "a map");
  if (!type.ok()) return type.status();
  return *type == "Topology" ? ReadTopoJson(*json) : ReadGeoJson(*json);
}

}  // namespace dynmesh::io
