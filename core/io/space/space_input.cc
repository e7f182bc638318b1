#include "core/io/space/space_input.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/coplanar/facet_rings.h"
#include "core/geometry/point.h"
#include "core/io/space/facet_sections.h"
#include "core/io/space/surface_work.h"

namespace dynmesh::io {

using coplanar::AxisView;
using coplanar::DepthsOf;
using coplanar::IsInDomain;
using coplanar::IsInside;
using coplanar::PointRing;
using coplanar::ViewOf;
using geometry::Point3;
using text::Concat;
namespace {

// Checks whether even-odd and the positions of holes give the same inside of a facet.
class HoleCheck {
 public:
  HoleCheck(const std::string& file, const Facet& facet, const std::vector<PointRing>& rings,
            const std::vector<int>& ring_lines)
      : file_(file), facet_(facet), rings_(rings), ring_lines_(ring_lines) {}

  absl::Status Run() const {
    if (auto s = CheckDomain(); !s.ok()) return s;
    const std::optional<AxisView> view = ViewOf(rings_[0]);
    if (!view) return Error(ring_lines_[0], "all corners of a polygon are on one line");
    const std::optional<std::vector<int>> depths = DepthsOf(rings_, *view);
    if (!depths) {
      return Error(facet_.line,
                   "a polygon touches another one of its facet with all of its corners; give each "
                   "piece a facet of its own");
    }
    std::vector<bool> has_position(rings_.size(), false);
    for (const SeedRow& hole : facet_.holes) {
      const std::vector<std::size_t> around = RingsAround(hole, *view);
      if (around.size() % 2 == 1) {
        return Error(hole.line,
                     "the place of a hole is on the facet: an odd number of its polygons goes "
                     "around it; move it into the hole");
      }
      for (const std::size_t i : around) {
        if ((*depths)[i] + 1 == static_cast<int>(around.size())) has_position[i] = true;
      }
    }
    for (std::size_t i = 0; i < rings_.size(); ++i) {
      if ((*depths)[i] % 2 == 0 || has_position[i]) continue;
      return Error(
          ring_lines_[i],
          "a polygon inside its facet without the place of a hole: polygons that only "
          "divide a facet are not supported; add the position, or make facets of the parts");
    }
    return absl::OkStatus();
  }

 private:
  absl::Status Error(int line, const std::string& message) const {
    return TextReader::ErrorAt(file_, line, message);
  }

  absl::Status CheckDomain() const {
    const auto check = [&](const std::array<double, 3>& position, int line) {
      if (IsInDomain(position)) return absl::OkStatus();
      return Error(line, "a coordinate is above 2^200 or nearer to 0 than 2^-200; scale the input");
    };
    for (std::size_t i = 0; i < rings_.size(); ++i) {
      for (const Point3& p : rings_[i]) {
        if (auto s = check(p.c, ring_lines_[i]); !s.ok()) return s;
      }
    }
    for (const SeedRow& hole : facet_.holes) {
      if (auto s = check(hole.position, hole.line); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  std::vector<std::size_t> RingsAround(const SeedRow& hole, AxisView view) const {
    std::vector<std::size_t> around;
    for (std::size_t i = 0; i < rings_.size(); ++i) {
      if (IsInside(rings_[i], Point3{hole.position}, view)) around.push_back(i);
    }
    return around;
  }

  const std::string& file_;
  const Facet& facet_;
  const std::vector<PointRing>& rings_;
  const std::vector<int>& ring_lines_;
};

absl::Status AddFacet(const Facet& facet, const std::string& file, SurfaceWork& work) {
  std::vector<SurfaceWork::Ring> rings;
  std::vector<int> lines;
  for (const FacetPolygon& polygon : facet.polygons) {
    if (polygon.corners.size() == 1) continue;
    if (polygon.corners.size() > 2) {
      rings.push_back(polygon.corners);
      lines.push_back(polygon.line);
    } else if (auto s = work.AddSegment(polygon.corners[0], polygon.corners[1], polygon.line,
                                        facet.marker);
               !s.ok()) {
      return s;
    }
  }
  if (rings.empty()) return absl::OkStatus();
  std::vector<PointRing> positions;
  if (rings.size() > 1 || !facet.holes.empty()) {
    for (const SurfaceWork::Ring& ring : rings) {
      PointRing& corners = positions.emplace_back();
      for (const SurfaceWork::Vertex v : ring) corners.push_back(Point3{work.position(v)});
    }
  }
  if (auto s = work.AddFace(std::move(rings), facet.line, facet.marker); !s.ok()) return s;
  if (positions.empty()) return absl::OkStatus();
  return HoleCheck(file, facet, positions, lines).Run();
}

template <class ReadFacets>
absl::StatusOr<FileFeatures> Parse(TextReader& reader, const OpenNodes& open_nodes,
                                   ReadFacets read_facets, FaceRules rules) {
  FileFeatures points;
  const absl::StatusOr<NodeSection> nodes = ReadPointsOfPoly(reader, 3, open_nodes, points);
  if (!nodes.ok()) return nodes.status();
  const absl::StatusOr<std::vector<Facet>> facets = read_facets(reader, *nodes);
  if (!facets.ok()) return facets.status();
  if (auto s = ReadSeedSections(reader, 3, points); !s.ok()) return s;
  SurfaceWork work(reader.name(), nodes->base, rules);
  work.StartFrom(std::move(points));
  for (const Facet& facet : *facets) {
    if (auto s = AddFacet(facet, reader.name(), work); !s.ok()) return s;
  }
  return work.Take();
}

}  // namespace

absl::StatusOr<FileFeatures> ParseSpaceNodeText(TextReader nodes) { return ParsePoints(nodes, 3); }

absl::StatusOr<FileFeatures> ParseSpacePolyText(TextReader poly, const OpenNodes& open_nodes,
                                                FaceRules rules) {
  return Parse(poly, open_nodes, ReadPolyFacets, rules);
}

absl::StatusOr<FileFeatures> ParseSmeshText(TextReader smesh, const OpenNodes& open_nodes,
                                            FaceRules rules) {
  return Parse(smesh, open_nodes, ReadSmeshFacets, rules);
}

absl::StatusOr<FileFeatures> ReadSpaceNodeFile(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseSpaceNodeText(*std::move(reader));
}

absl::StatusOr<FileFeatures> ReadSpacePolyFile(const std::string& path, FaceRules rules) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseSpacePolyText(*std::move(reader), OpenNodesBeside(path), rules);
}

absl::StatusOr<FileFeatures> ReadSmeshFile(const std::string& path, FaceRules rules) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseSmeshText(*std::move(reader), OpenNodesBeside(path), rules);
}

}  // namespace dynmesh::io
