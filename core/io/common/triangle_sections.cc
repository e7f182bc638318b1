#include "core/io/common/triangle_sections.h"

#include <algorithm>
#include <limits>
#include <string>

#include "core/base/text.h"
#include "core/io/common/section_rows.h"

namespace dynmesh::io {

using text::Concat;
namespace {

struct NodeHeader {
  int dimension = 2;
  std::uint64_t count = 0;
  std::uint64_t attributes = 0;
  bool has_markers = false;
};

absl::StatusOr<NodeHeader> ReadNodeHeader(TextReader& reader, int wanted) {
  if (!reader.Next()) return reader.Error("the file has no vertex header");
  absl::StatusOr<std::uint64_t> count = reader.Uint64(0, "the number of vertices");
  if (!count.ok()) return count.status();
  const std::uint64_t otherwise = wanted == kStatedDimension ? 2 : static_cast<unsigned>(wanted);
  absl::StatusOr<std::uint64_t> stated = HeaderValue(reader, 1, "the dimension", otherwise);
  if (!stated.ok()) return stated.status();
  const std::uint64_t dimension = wanted == kStatedDimension && *stated == 3 ? 3 : otherwise;
  if (dimension == 2 && *stated == 3) {
    return absl::UnimplementedError(Concat(reader.name(), ":", reader.line(),
                                           ": 3 dimensions are not supported yet in this version"));
  }
  if (*stated != 2 && *stated != 3) {
    return reader.Error(Concat("dimension ", *stated, " is neither 2 nor 3"));
  }
  if (*stated != dimension) {
    return reader.Error(Concat("dimension ", *stated, " is not ", dimension));
  }
  absl::StatusOr<std::uint64_t> attributes = HeaderValue(reader, 2, "the number of attributes", 0);
  if (!attributes.ok()) return attributes.status();
  absl::StatusOr<bool> has_markers = MarkerFlag(reader, 3);
  if (!has_markers.ok()) return has_markers.status();
  if (reader.size() > 4) return reader.Error("the vertex header has more than 4 values");
  if (*attributes > 1000) return reader.Error("more than 1000 attributes a vertex");
  if (*count >= std::numeric_limits<std::uint32_t>::max()) {
    return reader.Error(Concat(*count, " vertices are more than 2^32 - 2"));
  }
  return NodeHeader{static_cast<int>(dimension), *count, *attributes, *has_markers};
}

// The vertices of the current row, after its number.
template <std::size_t K>
absl::Status ReadCorners(const TextReader& reader, const NodeSection& nodes,
                         std::array<std::uint32_t, K>& corners) {
  for (std::size_t k = 0; k < K; ++k) {
    const absl::StatusOr<std::uint32_t> v =
        VertexIndex(reader, 1 + k, nodes.base, nodes.positions.size());
    if (!v.ok()) return v.status();
    corners[k] = *v;
  }
  return absl::OkStatus();
}

// Vertex i, if its row is nothing but the numbers that it should have. Else nothing has changed.
bool TakeUsualRow(TextReader& reader, const NodeHeader& header, std::uint64_t i,
                  NodeSection& nodes) {
  if (header.attributes != 0) return false;
  std::array<double, 3> position{};
  std::int64_t marker = 0;
  const bool is_usual = reader.TakeNext([&](NumberCursor& row) {
    std::uint64_t number = 0;
    if (!row.Take(&number) || number != nodes.base + i) return false;
    for (int k = 0; k < header.dimension; ++k) {
      if (!row.Take(&position[static_cast<std::size_t>(k)])) return false;
    }
    return !header.has_markers || row.Take(&marker);
  });
  if (!is_usual) return false;
  nodes.positions.push_back(position);
  nodes.markers.push_back(static_cast<std::uint64_t>(marker));
  nodes.lines.push_back(reader.line());
  return true;
}

// Empty if there is no such section.
absl::StatusOr<std::vector<SeedRow>> ReadSeeds(TextReader& reader, const char* what, int dimension,
                                               std::size_t more) {
  if (!reader.Next()) return std::vector<SeedRow>();
  const absl::StatusOr<std::uint64_t> count = ReadCount(reader, what, 1);
  if (!count.ok()) return count.status();
  return ReadSeedRows(reader, what, *count, dimension, more);
}

}  // namespace

absl::StatusOr<NodeSection> ReadNodeSection(TextReader& reader, int dimension) {
  const absl::StatusOr<NodeHeader> header = ReadNodeHeader(reader, dimension);
  if (!header.ok()) return header.status();
  const auto d = static_cast<std::size_t>(header->dimension);
  NodeSection nodes;
  nodes.dimension = header->dimension;
  nodes.attributes = header->attributes;
  nodes.has_markers = header->has_markers;
  const std::size_t rows = Reserve(header->count, reader);
  nodes.positions.reserve(rows);
  nodes.markers.reserve(rows);
  nodes.lines.reserve(rows);
  const std::size_t width = 1 + d + header->attributes + (header->has_markers ? 1 : 0);
  for (std::uint64_t i = 0; i < header->count; ++i) {
    // The first row tells the base; others are as usual, or read again for what is wrong.
    if (i != 0 && TakeUsualRow(reader, *header, i, nodes)) continue;
    if (auto s = NextRow(reader, "vertex", i, header->count); !s.ok()) return s;
    if (i == 0 && reader.token(0) == "0") nodes.base = 0;
    if (auto s = CheckNumber(reader, "vertex", nodes.base + i); !s.ok()) return s;
    if (auto s = CheckWidth(reader, "vertex", width); !s.ok()) return s;
    std::array<double, 3>& position = nodes.positions.emplace_back();
    for (std::size_t k = 0; k < d; ++k) {
      const absl::StatusOr<double> value =
          reader.Double(1 + k, std::string_view("xyz").substr(k, 1));
      if (!value.ok()) return value.status();
      position[k] = *value;
    }
    for (std::size_t k = 0; k < header->attributes; ++k) {
      const absl::StatusOr<double> value = reader.Double(1 + d + k, Concat("attribute ", k + 1));
      if (!value.ok()) return value.status();
      nodes.values.push_back(*value);
    }
    std::uint64_t mark = 0;
    if (header->has_markers) {
      const absl::StatusOr<std::uint64_t> marker = Marker(reader, width - 1);
      if (!marker.ok()) return marker.status();
      mark = *marker;
    }
    nodes.markers.push_back(mark);
    nodes.lines.push_back(reader.line());
  }
  return nodes;
}

template <std::size_t K>
absl::StatusOr<TupleSection<K>> ReadTupleSection(TextReader& reader, const char* what,
                                                 const NodeSection& nodes) {
  if (!reader.Next()) return reader.Error(Concat("the file has no ", what, " header"));
  const absl::StatusOr<std::uint64_t> count = ReadCount(reader, what, 2);
  if (!count.ok()) return count.status();
  const absl::StatusOr<bool> has_markers = MarkerFlag(reader, 1);
  if (!has_markers.ok()) return has_markers.status();
  TupleSection<K> rows;
  rows.has_markers = *has_markers;
  rows.ends.reserve(Reserve(*count, reader));
  std::uint64_t base = nodes.base;
  for (std::uint64_t i = 0; i < *count; ++i) {
    if (auto s = NextRow(reader, what, i, *count); !s.ok()) return s;
    if (i == 0 && (reader.token(0) == "0" || reader.token(0) == "1")) {
      base = reader.token(0) == "0" ? 0 : 1;
    }
    if (auto s = CheckNumber(reader, what, base + i); !s.ok()) return s;
    if (auto s = CheckWidth(reader, what, 1 + K + (*has_markers ? 1 : 0)); !s.ok()) return s;
    auto& ends = rows.ends.emplace_back();
    if (auto status = ReadCorners(reader, nodes, ends); !status.ok()) return status;
    std::uint64_t mark = 0;
    if (*has_markers) {
      const absl::StatusOr<std::uint64_t> marker = Marker(reader, 1 + K);
      if (!marker.ok()) return marker.status();
      mark = *marker;
    }
    rows.markers.push_back(mark);
    rows.lines.push_back(reader.line());
  }
  return rows;
}

template absl::StatusOr<TupleSection<2>> ReadTupleSection<2>(TextReader&, const char*,
                                                             const NodeSection&);
template absl::StatusOr<TupleSection<3>> ReadTupleSection<3>(TextReader&, const char*,
                                                             const NodeSection&);

template <int D>
absl::StatusOr<SimplexSection<D>> ReadSimplexSection(TextReader& reader, const NodeSection& nodes) {
  constexpr const char* kWhat = D == 2 ? "triangle" : "tetrahedron";
  constexpr std::uint64_t kCorners = D + 1;
  if (!reader.Next()) return reader.Error(Concat("the file has no ", kWhat, " header"));
  const absl::StatusOr<std::uint64_t> count = ReadCount(reader, kWhat, 3);
  if (!count.ok()) return count.status();
  const absl::StatusOr<std::uint64_t> corners =
      HeaderValue(reader, 1, "the number of corners", kCorners);
  if (!corners.ok()) return corners.status();
  if (*corners != kCorners) {
    return reader.Error(
        Concat(*corners, " nodes a ", kWhat, "; only ", kCorners, " are supported"));
  }
  const absl::StatusOr<std::uint64_t> attributes =
      HeaderValue(reader, 2, "the number of attributes", 0);
  if (!attributes.ok()) return attributes.status();
  if (*attributes > 1000) return reader.Error(Concat("more than 1000 attributes a ", kWhat));
  SimplexSection<D> rows;
  rows.corners.reserve(Reserve(*count, reader));
  for (std::uint64_t i = 0; i < *count; ++i) {
    if (auto s = NextRow(reader, kWhat, i, *count); !s.ok()) return s;
    if (auto s = CheckNumber(reader, kWhat, nodes.base + i); !s.ok()) return s;
    if (auto s = CheckWidth(reader, kWhat, 1 + kCorners + *attributes); !s.ok()) return s;
    auto& row = rows.corners.emplace_back();
    if (auto s = ReadCorners(reader, nodes, row); !s.ok()) return s;
    if (*attributes != 0) {
      double first = 0;
      if (!ParseDouble(reader.token(1 + kCorners), &first)) {
        first = std::numeric_limits<double>::quiet_NaN();
      }
      rows.attributes.push_back(first);
    }
    rows.lines.push_back(reader.line());
  }
  return rows;
}

template absl::StatusOr<SimplexSection<2>> ReadSimplexSection<2>(TextReader&, const NodeSection&);
template absl::StatusOr<SimplexSection<3>> ReadSimplexSection<3>(TextReader&, const NodeSection&);

absl::StatusOr<std::vector<SeedRow>> ReadSeedRows(TextReader& reader, const char* what,
                                                  std::uint64_t count, int dimension,
                                                  std::size_t more) {
  const auto d = static_cast<std::size_t>(dimension);
  const std::size_t least = 1 + d;
  const std::size_t most = least + more;
  std::vector<SeedRow> seeds;
  seeds.reserve(Reserve(count, reader));
  for (std::uint64_t i = 0; i < count; ++i) {
    if (auto s = NextRow(reader, what, i, count); !s.ok()) return s;
    if (auto number = reader.Uint64(0, Concat(what, " number")); !number.ok()) {
      return number.status();
    }
    if (reader.size() < least || reader.size() > most) {
      return reader.Error(Concat("a ", what, " row has ", least,
                                 least == most ? "" : Concat(" to ", most), " values, this one ",
                                 reader.size()));
    }
    SeedRow& seed = seeds.emplace_back();
    seed.line = reader.line();
    for (std::size_t k = 1; k < reader.size(); ++k) {
      const auto value = reader.Double(k, Concat("value ", k + 1, " of a ", what));
      if (!value.ok()) return value.status();
      if (k <= d) {
        seed.position[k - 1] = *value;
      } else {
        seed.more.push_back(*value);
      }
    }
  }
  return seeds;
}

absl::StatusOr<std::vector<SeedRow>> ReadHoleSection(TextReader& reader, int dimension) {
  return ReadSeeds(reader, "hole", dimension, 0);
}

absl::StatusOr<std::vector<SeedRow>> ReadRegionSection(TextReader& reader, int dimension) {
  return ReadSeeds(reader, "region", dimension, 2);
}

absl::Status ExpectEnd(TextReader& reader) {
  if (!reader.Next()) return absl::OkStatus();
  return reader.Error("more values after the last row that the headers announce");
}

}  // namespace dynmesh::io
