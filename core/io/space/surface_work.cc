#include "core/io/space/surface_work.h"

#include <algorithm>

#include "core/base/rings.h"
#include "core/base/text.h"
#include "core/io/common/node_input.h"
#include "core/io/common/text_reader.h"

namespace dynmesh::io {

using text::Concat;

absl::Status SurfaceWork::Error(int line, const std::string& message) const {
  return TextReader::ErrorAt(file_, line, message);
}

std::string SurfaceWork::Name(Vertex v) const { return Concat(first_number_ + v); }

SurfaceWork::Vertex SurfaceWork::AddPoint(const std::array<double, 3>& position, int line) {
  const auto v = static_cast<Vertex>(input_.features.size());
  input_.features.push_back(
      Feature::Point(FeatureId{v} + 1, position[0], position[1], position[2]));
  input_.lines.push_back(line);
  return v;
}

absl::Status SurfaceWork::AddSegment(Vertex p, Vertex q, int line, std::uint64_t marker) {
  if (p == q && rules_ == FaceRules::kAsTheyCome) return absl::OkStatus();
  if (p == q) {
    return Error(line, Concat("a segment has vertex ", Name(p), " at both ends; leave it out"));
  }
  if (joined_.insert(std::minmax(p, q)).second) segments_.push_back({p, q, line, marker});
  return absl::OkStatus();
}

absl::Status SurfaceWork::CheckRing(const Ring& ring, int line) const {
  Ring sorted = ring;
  if (rules_ == FaceRules::kMended) {
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    while (sorted.size() > 1 && sorted.front() == sorted.back()) sorted.pop_back();
  }
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    return Error(line, Concat("a face visits vertex ", Name(*twice),
                              " twice; leave it out, or make it faces that touch there"));
  }
  if (ring.size() >= 3) return absl::OkStatus();
  return Error(line, Concat("a face has ", ring.size(), ring.size() == 1 ? " corner" : " corners",
                            ", fewer than 3; leave it out"));
}

absl::Status SurfaceWork::CheckEdges(const std::vector<Ring>& rings, int line) const {
  std::vector<std::pair<Vertex, Vertex>> edges;
  ForEachEdgeOf(rings, [&](Vertex p, Vertex q) { edges.push_back(std::minmax(p, q)); });
  std::sort(edges.begin(), edges.end());
  const auto twice = std::adjacent_find(edges.begin(), edges.end());
  if (twice == edges.end()) return absl::OkStatus();
  return Error(line, Concat("a facet has the edge between vertices ", Name(twice->first), " and ",
                            Name(twice->second),
                            " twice; make polygons that lie side by side facets of their own"));
}

absl::Status SurfaceWork::AddFace(std::vector<Ring> rings, int line, std::uint64_t marker) {
  if (rules_ == FaceRules::kAsTheyCome) {
    std::erase_if(rings, [](const Ring& ring) { return ring.empty(); });
    if (!rings.empty()) faces_.push_back({std::move(rings), line, marker});
    return absl::OkStatus();
  }
  Ring corners;
  for (const Ring& ring : rings) {
    if (auto s = CheckRing(ring, line); !s.ok()) return s;
    corners.insert(corners.end(), ring.begin(), ring.end());
  }
  if (rings.size() > 1) {
    if (auto s = CheckEdges(rings, line); !s.ok()) return s;
  }
  std::sort(corners.begin(), corners.end());
  const auto [it, fresh] = line_of_.emplace(std::move(corners), line);
  if (!fresh && rules_ == FaceRules::kStrict) {
    return Error(line, Concat("a face has the same corners as the one on line ", it->second,
                              "; leave one of them out"));
  }
  faces_.push_back({std::move(rings), line, marker});
  return absl::OkStatus();
}

FileFeatures SurfaceWork::Take() {
  FileFeatures input = std::move(input_);
  if (input.point_file.empty()) input.point_file = file_;
  input.segment_file = file_;
  input.rounding = digits_.Rounding();
  input.point_count = input.features.size();
  input.segment_count = segments_.size();
  FeatureId id = input.features.size();
  for (const Segment& s : segments_) {
    input.features.push_back(Feature::Segment(++id, FeatureId{s.p} + 1, FeatureId{s.q} + 1));
    input.lines.push_back(s.line);
    AddMarkers({&s.marker, 1}, id, input.labels);
  }
  for (const Face& face : faces_) {
    Rings rings;
    for (const Ring& ring : face.rings) {
      std::vector<FeatureId>& corners = rings.emplace_back();
      for (const Vertex corner : ring) corners.push_back(FeatureId{corner} + 1);
    }
    input.features.push_back(Feature::Polygon(++id, std::move(rings)));
    input.lines.push_back(face.line);
    AddMarkers({&face.marker, 1}, id, input.labels);
  }
  *this = SurfaceWork(file_, first_number_, rules_);
  return input;
}

}  // namespace dynmesh::io
