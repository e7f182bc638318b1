#include "core/io/space/facet_sections.h"

#include <utility>

#include "core/base/text.h"
#include "core/io/common/section_rows.h"

namespace dynmesh::io {

using text::Concat;
namespace {

struct FacetHeader {
  std::uint64_t count = 0;
  bool has_markers = false;
};

absl::StatusOr<FacetHeader> ReadFacetHeader(TextReader& reader) {
  if (!reader.Next()) return reader.Error("the file has no facet header");
  const absl::StatusOr<std::uint64_t> count = ReadCount(reader, "facet", 2);
  if (!count.ok()) return count.status();
  const absl::StatusOr<bool> has_markers = MarkerFlag(reader, 1);
  if (!has_markers.ok()) return has_markers.status();
  return FacetHeader{*count, *has_markers};
}

// Reads "count corner corner ..." from the start of the current line. Sets `next` to the token
// after them, on the then current line.
absl::StatusOr<FacetPolygon> ReadPolygon(TextReader& reader, const NodeSection& nodes,
                                         std::size_t& next) {
  FacetPolygon polygon;
  polygon.line = reader.line();
  const absl::StatusOr<std::uint64_t> count = reader.Uint64(0, "the number of corners");
  if (!count.ok()) return count.status();
  if (*count == 0) return reader.Error("a polygon without corners; leave it out");
  polygon.corners.reserve(Reserve(*count, reader));
  next = 1;
  for (std::uint64_t i = 0; i < *count; ++i, ++next) {
    if (next == reader.size()) {
      if (auto s = NextRow(reader, "corner", i, *count); !s.ok()) return s;
      next = 0;
    }
    const auto v = VertexIndex(reader, next, nodes.base, nodes.positions.size());
    if (!v.ok()) return v.status();
    polygon.corners.push_back(*v);
  }
  return polygon;
}

// Reads what may follow at token `next`: the facet's marker, if the header says so.
absl::Status ReadRest(const TextReader& reader, std::size_t next, bool has_markers, Facet& facet) {
  if (has_markers && next < reader.size()) {
    const absl::StatusOr<std::uint64_t> marker = Marker(reader, next);
    if (!marker.ok()) return marker.status();
    facet.marker = *marker;
    ++next;
  }
  if (next >= reader.size()) return absl::OkStatus();
  return reader.Error(
      Concat("more values on this line than the number of corners and the headers announce, from '",
             reader.token(next).substr(0, 20), "' on"));
}

// Reads the polygon from the start of the current line to the end of the facet.
absl::Status AddPolygon(TextReader& reader, const NodeSection& nodes, bool has_markers,
                        Facet& facet) {
  std::size_t next = 0;
  absl::StatusOr<FacetPolygon> polygon = ReadPolygon(reader, nodes, next);
  if (!polygon.ok()) return polygon.status();
  facet.polygons.push_back(*std::move(polygon));
  return ReadRest(reader, next, has_markers, facet);
}

// Calls read(facet, has_markers) on the first line of each facet.
template <class Read>
absl::StatusOr<std::vector<Facet>> ReadFacets(TextReader& reader, Read read) {
  const absl::StatusOr<FacetHeader> header = ReadFacetHeader(reader);
  if (!header.ok()) return header.status();
  std::vector<Facet> facets;
  for (std::uint64_t i = 0; i < header->count; ++i) {
    if (auto s = NextRow(reader, "facet", i, header->count); !s.ok()) return s;
    Facet& facet = facets.emplace_back();
    facet.line = reader.line();
    if (absl::Status s = read(facet, header->has_markers); !s.ok()) return s;
  }
  return facets;
}

}  // namespace

absl::StatusOr<std::vector<Facet>> ReadSmeshFacets(TextReader& reader, const NodeSection& nodes) {
  return ReadFacets(reader, [&](Facet& facet, bool has_markers) {
    return AddPolygon(reader, nodes, has_markers, facet);
  });
}

absl::StatusOr<std::vector<Facet>> ReadPolyFacets(TextReader& reader, const NodeSection& nodes) {
  return ReadFacets(reader, [&](Facet& facet, bool has_markers) -> absl::Status {
    const auto polygons = reader.Uint64(0, "the number of polygons");
    if (!polygons.ok()) return polygons.status();
    const auto holes = HeaderValue(reader, 1, "the number of holes", 0);
    if (!holes.ok()) return holes.status();
    if (auto s = ReadRest(reader, 2, has_markers, facet); !s.ok()) return s;
    for (std::uint64_t k = 0; k < *polygons; ++k) {
      if (auto s = NextRow(reader, "polygon", k, *polygons); !s.ok()) return s;
      if (auto s = AddPolygon(reader, nodes, false, facet); !s.ok()) return s;
    }
    absl::StatusOr<std::vector<SeedRow>> positions = ReadSeedRows(reader, "hole", *holes, 3, 0);
    if (!positions.ok()) return positions.status();
    facet.holes = *std::move(positions);
    return absl::OkStatus();
  });
}

}  // namespace dynmesh::io
