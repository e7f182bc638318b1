#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/maps/json_fields.h"
#include "core/io/maps/line_work.h"
#include "core/io/maps/map_files.h"

namespace dynmesh::io {
namespace {

using text::Concat;
using text::Quoted;
using Index = JsonDocument::Index;
using Kind = JsonDocument::Kind;
using Pair = std::array<double, 2>;

class TopoJsonReader {
 public:
  TopoJsonReader(const JsonDocument& json, bool polygons) : json_(json), polygons_(polygons) {}

  absl::StatusOr<FileFeatures> Read() {
    const auto arcs = Member(json_, 0, "arcs", Kind::kArray, "a Topology");
    if (!arcs.ok()) return arcs.status();
    const auto objects = Member(json_, 0, "objects", Kind::kObject, "a Topology");
    if (!objects.ok()) return objects.status();
    if (auto status = ReadTransform(); !status.ok()) return status;
    arcs_.resize(Count(json_, *arcs));
    // First finds the used arcs and the points, then reads the arcs.
    const absl::Status status =
        json_.ForEach(*objects, [this](Index g) { return ReadGeometry(g); });
    if (!status.ok()) return status;
    std::size_t n = 0;
    const absl::Status drawn = json_.ForEach(*arcs, [&](Index v) {
      Arc& arc = arcs_[n++];
      return arc.is_line || arc.is_border ? ReadArc(v, arc) : absl::OkStatus();
    });
    if (!drawn.ok()) return drawn;
    for (const Index v : points_) {
      if (auto added = AddPoint(v); !added.ok()) return added;
    }
    for (const Index v : areas_) {
      if (auto added = AddPolygon(v); !added.ok()) return added;
    }
    FileFeatures input = work_.Take(json_.name());
    input.heights = heights_;
    input.gaps = gaps_;
    return input;
  }

 private:
  using Path = std::vector<LineWork::Node>;
  struct Arc {
    bool is_line = false;    // its edges become segments
    bool is_border = false;  // a polygon uses it
    Path path = {};
  };
  struct ArcUse {
    std::size_t arc;
    bool backwards;
  };

  absl::Status ReadTransform() {
    if (!json_.Find(0, "transform")) return absl::OkStatus();
    const auto transform = Member(json_, 0, "transform", Kind::kObject, "a Topology");
    if (!transform.ok()) return transform.status();
    for (const auto& [key, value] : {std::pair("scale", &scale_), {"translate", &translate_}}) {
      const auto member = Member(json_, *transform, key, Kind::kArray, "the transform");
      if (!member.ok()) return member.status();
      const absl::StatusOr<Position> pair = ReadPosition(json_, *member);
      if (!pair.ok()) return pair.status();
      *value = pair->at;
    }
    quantised_ = true;
    return absl::OkStatus();
  }

  absl::Status ReadGeometry(Index v) {
    if (json_.kind(v) == Kind::kNull) return absl::OkStatus();
    // An object without a geometry has type null.
    if (json_.kind(v) == Kind::kObject) {
      const std::optional<Index> type = json_.Find(v, "type");
      if (type && json_.kind(*type) == Kind::kNull) return absl::OkStatus();
    }
    const absl::StatusOr<std::string_view> type = TypeOf(json_, v, "a geometry");
    if (!type.ok()) return type.status();
    if (*type == "GeometryCollection") {
      const auto members = Member(json_, v, "geometries", Kind::kArray, *type);
      if (!members.ok()) return members.status();
      return json_.ForEach(*members, [this](Index g) { return ReadGeometry(g); });
    }
    if (*type == "Point" || *type == "MultiPoint") return ReadPoints(v, *type);
    constexpr struct {
      std::string_view type;
      int arrays;  // nesting depth around the numbers of arcs
    } kOfArcs[] = {{"LineString", 1}, {"MultiLineString", 2}, {"Polygon", 2}, {"MultiPolygon", 3}};
    for (const auto& kind : kOfArcs) {
      if (*type != kind.type) continue;
      const auto arcs = Member(json_, v, "arcs", Kind::kArray, *type);
      if (!arcs.ok()) return arcs.status();
      const bool is_area = polygons_ && kind.type.ends_with("Polygon");
      if (is_area) areas_.push_back(v);
      return ForEachArc(*arcs, kind.arrays, [&](ArcUse use) {
        Arc& arc = arcs_[use.arc];
        (is_area ? arc.is_border : arc.is_line) = true;
        return absl::OkStatus();
      });
    }
    return json_.Error(v, Concat("unknown type ", Quoted(*type),
                                 ": expected Point, MultiPoint, LineString, MultiLineString, "
                                 "Polygon, MultiPolygon or GeometryCollection"));
  }

  absl::Status ReadPoints(Index v, std::string_view type) {
    const auto coordinates = Member(json_, v, "coordinates", Kind::kArray, type);
    if (!coordinates.ok()) return coordinates.status();
    if (type == "Point") {
      points_.push_back(*coordinates);
      return absl::OkStatus();
    }
    return json_.ForEach(*coordinates, [this](Index i) {
      points_.push_back(i);
      return absl::OkStatus();
    });
  }

  // Visits arrays of arrays of ... numbers of arcs. Arc n reversed is ~n = -1 - n.
  template <class Visit>
  absl::Status ForEachArc(Index v, int arrays, const Visit& visit) {
    if (arrays > 0) {
      if (auto status = ExpectArray(json_, v, "a list of arcs"); !status.ok()) return status;
      return json_.ForEach(v, [&](Index i) { return ForEachArc(i, arrays - 1, visit); });
    }
    if (json_.kind(v) != Kind::kNumber) return json_.Error(v, "the number of an arc is no number");
    const double number = json_.number(v);
    const double arc = number < 0 ? -1 - number : number;
    if (!(arc < static_cast<double>(arcs_.size())) || arc != std::floor(arc)) {
      return json_.Error(
          v, Concat("there is no arc ", FormatDouble(number), ": the topology has ", arcs_.size()));
    }
    return visit(ArcUse{static_cast<std::size_t>(arc), number < 0});
  }

  // Its arcs are read and valid already. If an arc does not begin where the one before ends, or
  // the last does not end where the first begins (as in us-atlas), an edge closes the gap.
  absl::Status AddPolygon(Index v) {
    std::vector<Path> rings;
    const auto add_ring = [&](Index ring) {
      Path path;
      const absl::Status status = ForEachArc(ring, 1, [&](ArcUse use) {
        Path next = arcs_[use.arc].path;
        if (use.backwards) std::reverse(next.begin(), next.end());
        gaps_ += !path.empty() && path.back() != next.front() ? 1 : 0;
        path.insert(path.end(), next.begin(), next.end());
        return absl::OkStatus();
      });
      if (path.empty()) return status;
      gaps_ += path.front() != path.back() ? 1 : 0;
      rings.push_back(std::move(path));
      return status;
    };
    const Index arcs = *json_.Find(v, "arcs");
    const bool is_multiple = json_.text(*json_.Find(v, "type")) == "MultiPolygon";
    const absl::Status status = json_.ForEach(
        arcs, [&](Index i) { return is_multiple ? json_.ForEach(i, add_ring) : add_ring(i); });
    if (status.ok()) work_.AddPolygon(std::move(rings), NamesOf(json_, v), json_.line(v));
    return status;
  }

  Pair Place(const Pair& q) const {
    if (!quantised_) return q;
    return {q[0] * scale_[0] + translate_[0], q[1] * scale_[1] + translate_[1]};
  }

  absl::Status ReadArc(Index arc, Arc& read) {
    if (auto status = ExpectArray(json_, arc, "an arc"); !status.ok()) return status;
    if (Count(json_, arc) < 2) return json_.Error(arc, "an arc needs 2 positions");
    Pair sum = {0, 0};
    return json_.ForEach(arc, [&](Index i) {
      const absl::StatusOr<Position> position = ReadPosition(json_, i);
      if (!position.ok()) return position.status();
      heights_ += position->has_more ? 1 : 0;
      for (std::size_t k = 0; k < 2; ++k) {
        // A quantised arc is a first position, then differences.
        sum[k] = quantised_ ? sum[k] + position->at[k] : position->at[k];
      }
      const Pair at = Place(sum);
      if (auto status = CheckMagnitude(json_, i, at); !status.ok()) return status;
      const LineWork::Node here = work_.Add(at, json_.line(i));
      if (read.is_line && !read.path.empty()) work_.Connect(read.path.back(), here, json_.line(i));
      read.path.push_back(here);
      return absl::OkStatus();
    });
  }

  absl::Status AddPoint(Index v) {
    const absl::StatusOr<Position> position = ReadPosition(json_, v);
    if (!position.ok()) return position.status();
    heights_ += position->has_more ? 1 : 0;
    const Pair at = Place(position->at);
    if (auto status = CheckMagnitude(json_, v, at); !status.ok()) return status;
    work_.Add(at, json_.line(v));
    return absl::OkStatus();
  }

  const JsonDocument& json_;
  const bool polygons_;
  bool quantised_ = false;
  Pair scale_ = {1, 1};
  Pair translate_ = {0, 0};
  std::vector<Arc> arcs_;
  std::vector<Index> points_;  // positions of the objects' own points
  std::vector<Index> areas_;   // geometries that become polygons
  LineWork work_;
  std::uint64_t heights_ = 0;
  std::uint64_t gaps_ = 0;
};

}  // namespace

absl::StatusOr<FileFeatures> ReadTopoJson(const JsonDocument& json, bool polygons) {
  return TopoJsonReader(json, polygons).Read();
}

}  // namespace dynmesh::io
