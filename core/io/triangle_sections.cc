#include "core/io/triangle_sections.h"

#include <algorithm>
#include <limits>
#include <string>

#include "core/data/text.h"

namespace dynmesh::io {

using data::Concat;
namespace {

// More rows than any file of this size holds make no claim on memory.
std::size_t Reserve(std::uint64_t count, const TextReader& reader) {
  return static_cast<std::size_t>(std::min<std::uint64_t>(count, reader.text_size() / 4 + 1));
}

// A header value that may be left out.
absl::StatusOr<std::uint64_t> HeaderValue(const TextReader& reader, std::size_t i, const char* what,
                                          std::uint64_t otherwise) {
  if (i >= reader.size()) return otherwise;
  return reader.Uint64(i, what);
}

absl::Status NextRow(TextReader& reader, const char* what, std::uint64_t row, std::uint64_t count) {
  if (reader.Next()) return absl::OkStatus();
  return reader.Error(Concat("the file ends after ", row, " of ", count, " ", what, " rows"));
}

// Rows count up from `base`, so that a lost or doubled line is seen.
absl::Status CheckNumber(const TextReader& reader, const char* what, std::uint64_t expected) {
  absl::StatusOr<std::uint64_t> number = reader.Uint64(0, Concat(what, " number"));
  if (!number.ok()) return number.status();
  if (*number == expected) return absl::OkStatus();
  return reader.Error(Concat(what, " number ", expected, " expected here, found ", *number));
}

absl::Status CheckWidth(const TextReader& reader, const char* what, std::size_t width) {
  if (reader.size() == width) return absl::OkStatus();
  return reader.Error(Concat("a ", what, " row has ", width,
                             " values according to its header, this one ", reader.size()));
}

// Markers are signed in these files; feature ids need all 64 bits.
absl::StatusOr<std::uint64_t> Marker(const TextReader& reader, std::size_t i) {
  std::int64_t negative = 0;
  if (i < reader.size() && ParseInt64(reader.token(i), &negative) && negative < 0) {
    return static_cast<std::uint64_t>(negative);
  }
  return reader.Uint64(i, "marker");
}

absl::StatusOr<bool> MarkerFlag(const TextReader& reader, std::size_t i) {
  absl::StatusOr<std::uint64_t> flag = HeaderValue(reader, i, "the number of markers", 0);
  if (!flag.ok()) return flag.status();
  if (*flag > 1) return reader.Error("the number of markers a row must be 0 or 1");
  return *flag == 1;
}

absl::StatusOr<std::uint32_t> VertexIndex(const TextReader& reader, std::size_t i,
                                          const NodeSection& nodes) {
  absl::StatusOr<std::uint64_t> number = reader.Uint64(i, "vertex number");
  if (!number.ok()) return number.status();
  const std::uint64_t index = *number - nodes.base;  // 0 with base 1 wraps round: too large
  if (index >= nodes.positions.size()) {
    if (nodes.positions.empty()) {
      return reader.Error(Concat("vertex ", *number, " does not exist: there is none"));
    }
    return reader.Error(Concat("vertex ", *number, " does not exist: they run from ", nodes.base,
                               " to ", nodes.base + nodes.positions.size() - 1));
  }
  return static_cast<std::uint32_t>(index);
}

struct NodeHeader {
  std::uint64_t count = 0;
  std::uint64_t attributes = 0;
  bool has_markers = false;
};

absl::StatusOr<NodeHeader> ReadNodeHeader(TextReader& reader) {
  if (!reader.Next()) return reader.Error("the file has no vertex header");
  absl::StatusOr<std::uint64_t> count = reader.Uint64(0, "the number of vertices");
  if (!count.ok()) return count.status();
  absl::StatusOr<std::uint64_t> dimension = HeaderValue(reader, 1, "the dimension", 2);
  if (!dimension.ok()) return dimension.status();
  if (*dimension == 3) {
    return absl::UnimplementedError(Concat(reader.name(), ":", reader.line(),
                                           ": 3 dimensions are not supported yet in this version"));
  }
  if (*dimension != 2) return reader.Error(Concat("dimension ", *dimension, " is not 2"));
  absl::StatusOr<std::uint64_t> attributes = HeaderValue(reader, 2, "the number of attributes", 0);
  if (!attributes.ok()) return attributes.status();
  absl::StatusOr<bool> has_markers = MarkerFlag(reader, 3);
  if (!has_markers.ok()) return has_markers.status();
  if (reader.size() > 4) return reader.Error("the vertex header has more than 4 values");
  if (*attributes > 1000) return reader.Error("more than 1000 attributes a vertex");
  if (*count >= std::numeric_limits<std::uint32_t>::max()) {
    return reader.Error(Concat(*count, " vertices are more than 2^32 - 2"));
  }
  return NodeHeader{*count, *attributes, *has_markers};
}

absl::StatusOr<std::uint64_t> ReadCount(TextReader& reader, const char* what,
                                        std::size_t max_header) {
  absl::StatusOr<std::uint64_t> count = reader.Uint64(0, Concat("the number of ", what, "s"));
  if (!count.ok()) return count.status();
  if (reader.size() > max_header) {
    return reader.Error(Concat("the ", what, " header has more than ", max_header,
                               max_header == 1 ? " value" : " values"));
  }
  return count;
}

// Rows that are checked and then not used.
absl::StatusOr<std::uint64_t> SkipSection(TextReader& reader, const char* what, std::size_t least,
                                          std::size_t most) {
  if (!reader.Next()) return 0;
  absl::StatusOr<std::uint64_t> count = ReadCount(reader, what, 1);
  if (!count.ok()) return count.status();
  for (std::uint64_t i = 0; i < *count; ++i) {
    if (auto s = NextRow(reader, what, i, *count); !s.ok()) return s;
    if (auto number = reader.Uint64(0, Concat(what, " number")); !number.ok()) {
      return number.status();
    }
    if (reader.size() < least || reader.size() > most) {
      return reader.Error(Concat("a ", what, " row has ", least,
                                 least == most ? "" : Concat(" to ", most), " values, this one ",
                                 reader.size()));
    }
    for (std::size_t k = 1; k < reader.size(); ++k) {
      if (auto value = reader.Double(k, Concat("value ", k + 1, " of a ", what)); !value.ok()) {
        return value.status();
      }
    }
  }
  return *count;
}

}  // namespace

absl::StatusOr<NodeSection> ReadNodeSection(TextReader& reader) {
  const absl::StatusOr<NodeHeader> header = ReadNodeHeader(reader);
  if (!header.ok()) return header.status();
  NodeSection nodes;
  nodes.attributes = header->attributes;
  nodes.has_markers = header->has_markers;
  nodes.positions.reserve(Reserve(header->count, reader));
  const std::size_t width = 3 + header->attributes + (header->has_markers ? 1 : 0);
  for (std::uint64_t i = 0; i < header->count; ++i) {
    if (auto s = NextRow(reader, "vertex", i, header->count); !s.ok()) return s;
    if (i == 0 && reader.token(0) == "0") nodes.base = 0;
    if (auto s = CheckNumber(reader, "vertex", nodes.base + i); !s.ok()) return s;
    if (auto s = CheckWidth(reader, "vertex", width); !s.ok()) return s;
    const absl::StatusOr<double> x = reader.Double(1, "x");
    if (!x.ok()) return x.status();
    const absl::StatusOr<double> y = reader.Double(2, "y");
    if (!y.ok()) return y.status();
    for (std::size_t k = 0; k < header->attributes; ++k) {
      if (auto a = reader.Double(3 + k, Concat("attribute ", k + 1)); !a.ok()) {
        return a.status();
      }
    }
    std::uint64_t mark = 0;
    if (header->has_markers) {
      const absl::StatusOr<std::uint64_t> marker = Marker(reader, width - 1);
      if (!marker.ok()) return marker.status();
      mark = *marker;
    }
    nodes.positions.push_back({*x, *y});
    nodes.markers.push_back(mark);
    nodes.lines.push_back(reader.line());
  }
  return nodes;
}

absl::StatusOr<PairSection> ReadPairSection(TextReader& reader, const char* what,
                                            const NodeSection& nodes) {
  if (!reader.Next()) return reader.Error(Concat("the file has no ", what, " header"));
  const absl::StatusOr<std::uint64_t> count = ReadCount(reader, what, 2);
  if (!count.ok()) return count.status();
  const absl::StatusOr<bool> has_markers = MarkerFlag(reader, 1);
  if (!has_markers.ok()) return has_markers.status();
  PairSection pairs;
  pairs.has_markers = *has_markers;
  pairs.ends.reserve(Reserve(*count, reader));
  std::uint64_t base = nodes.base;
  for (std::uint64_t i = 0; i < *count; ++i) {
    if (auto s = NextRow(reader, what, i, *count); !s.ok()) return s;
    if (i == 0 && (reader.token(0) == "0" || reader.token(0) == "1")) {
      base = reader.token(0) == "0" ? 0 : 1;
    }
    if (auto s = CheckNumber(reader, what, base + i); !s.ok()) return s;
    if (auto s = CheckWidth(reader, what, *has_markers ? 4 : 3); !s.ok()) return s;
    const absl::StatusOr<std::uint32_t> a = VertexIndex(reader, 1, nodes);
    if (!a.ok()) return a.status();
    const absl::StatusOr<std::uint32_t> b = VertexIndex(reader, 2, nodes);
    if (!b.ok()) return b.status();
    std::uint64_t mark = 0;
    if (*has_markers) {
      const absl::StatusOr<std::uint64_t> marker = Marker(reader, 3);
      if (!marker.ok()) return marker.status();
      mark = *marker;
    }
    pairs.ends.push_back({*a, *b});
    pairs.markers.push_back(mark);
    pairs.lines.push_back(reader.line());
  }
  return pairs;
}

absl::StatusOr<TriangleSection> ReadTriangleSection(TextReader& reader, const NodeSection& nodes) {
  if (!reader.Next()) return reader.Error("the file has no triangle header");
  const absl::StatusOr<std::uint64_t> count = ReadCount(reader, "triangle", 3);
  if (!count.ok()) return count.status();
  const absl::StatusOr<std::uint64_t> corners = HeaderValue(reader, 1, "the number of corners", 3);
  if (!corners.ok()) return corners.status();
  if (*corners != 3) {
    return reader.Error(Concat(*corners, " nodes a triangle; only 3 are supported"));
  }
  const absl::StatusOr<std::uint64_t> attributes =
      HeaderValue(reader, 2, "the number of attributes", 0);
  if (!attributes.ok()) return attributes.status();
  if (*attributes > 1000) return reader.Error("more than 1000 attributes a triangle");
  TriangleSection triangles;
  triangles.corners.reserve(Reserve(*count, reader));
  for (std::uint64_t i = 0; i < *count; ++i) {
    if (auto s = NextRow(reader, "triangle", i, *count); !s.ok()) return s;
    if (auto s = CheckNumber(reader, "triangle", nodes.base + i); !s.ok()) return s;
    if (auto s = CheckWidth(reader, "triangle", 4 + *attributes); !s.ok()) return s;
    std::array<std::uint32_t, 3> t{};
    for (std::size_t k = 0; k < 3; ++k) {
      const absl::StatusOr<std::uint32_t> v = VertexIndex(reader, 1 + k, nodes);
      if (!v.ok()) return v.status();
      t[k] = *v;
    }
    triangles.corners.push_back(t);
    if (*attributes != 0) {
      double first = 0;
      if (!ParseDouble(reader.token(4), &first)) first = std::numeric_limits<double>::quiet_NaN();
      triangles.attributes.push_back(first);
    }
    triangles.lines.push_back(reader.line());
  }
  return triangles;
}

absl::StatusOr<std::uint64_t> ReadHoleSection(TextReader& reader) {
  return SkipSection(reader, "hole", 3, 3);
}

absl::StatusOr<std::uint64_t> ReadRegionSection(TextReader& reader) {
  return SkipSection(reader, "region", 3, 5);
}

absl::Status ExpectEnd(TextReader& reader) {
  if (!reader.Next()) return absl::OkStatus();
  return reader.Error("more values after the last row that the headers announce");
}

}  // namespace dynmesh::io
