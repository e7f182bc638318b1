#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>

#include "core/base/text.h"
#include "core/io/common/section_rows.h"
#include "core/io/space/surface_files.h"
#include "core/io/space/surface_work.h"

namespace dynmesh::io {

using text::Concat;
using text::Quoted;
namespace {

// Skips the header; the counts are then the tokens from the returned one on.
absl::StatusOr<std::size_t> ReadOffHeader(TextReader& off) {
  if (!off.Next()) return off.Error("the file is empty: it has no line OFF");
  std::string_view kind = off.token(0);
  if (!kind.ends_with("OFF")) {
    return off.Error(Concat("an .off file starts with OFF, this one with ", Quoted(kind)));
  }
  kind.remove_suffix(3);
  for (const std::string_view part : {"ST", "C", "N"}) {
    if (kind.starts_with(part)) kind.remove_prefix(part.size());
  }
  if (!kind.empty()) {
    return off.Error(Concat(Quoted(off.token(0)),
                            " files are not supported; write OFF, with three coordinates"));
  }
  if (off.size() > 1 && off.token(1) == "BINARY") {
    return off.Error("binary .off files are not supported; write it as text");
  }
  if (off.size() > 1) return std::size_t{1};
  if (!off.Next()) return off.Error("the file ends before the counts of vertices and faces");
  return std::size_t{0};
}

absl::Status ReadVertices(TextReader& off, std::uint64_t count, SurfaceWork& work) {
  for (std::uint64_t i = 0; i < count; ++i) {
    if (auto s = NextRow(off, "vertex", i, count); !s.ok()) return s;
    const auto position = ReadPosition3(off, 0, &work.digits());
    if (!position.ok()) return position.status();
    work.AddPoint(*position, off.line());
  }
  return absl::OkStatus();
}

absl::Status ReadFaces(TextReader& off, std::uint64_t count, SurfaceWork& work) {
  for (std::uint64_t i = 0; i < count; ++i) {
    if (auto s = NextRow(off, "face", i, count); !s.ok()) return s;
    const auto corners = off.Uint64(0, "the number of corners");
    if (!corners.ok()) return corners.status();
    if (*corners >= off.size()) {
      return off.Error(Concat("a face of ", *corners, " corners has only ", off.size() - 1));
    }
    SurfaceWork::Ring ring;
    for (std::size_t k = 1; k <= *corners; ++k) {
      const auto v = VertexIndex(off, k, 0, work.point_count());
      if (!v.ok()) return v.status();
      ring.push_back(*v);
    }
    if (auto s = work.AddFace({std::move(ring)}, off.line()); !s.ok()) return s;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<FileFeatures> ParseOffText(TextReader off, FaceRules rules) {
  const absl::StatusOr<std::size_t> first = ReadOffHeader(off);
  if (!first.ok()) return first.status();
  const auto vertices = off.Uint64(*first, "the number of vertices");
  if (!vertices.ok()) return vertices.status();
  const auto faces = off.Uint64(*first + 1, "the number of faces");
  if (!faces.ok()) return faces.status();
  if (off.size() > *first + 3) {
    return off.Error("more than the counts of vertices, faces and edges");
  }
  if (*vertices >= std::numeric_limits<std::uint32_t>::max()) {
    return off.Error(Concat(*vertices, " vertices are more than 2^32 - 2"));
  }
  SurfaceWork work(off.name(), 0, rules);
  if (auto s = ReadVertices(off, *vertices, work); !s.ok()) return s;
  if (auto s = ReadFaces(off, *faces, work); !s.ok()) return s;
  if (auto s = ExpectEnd(off); !s.ok()) return s;
  return work.Take();
}

absl::StatusOr<FileFeatures> ReadOffFile(const std::string& path, FaceRules rules) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseOffText(*std::move(reader), rules);
}

}  // namespace dynmesh::io
