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

// "v", "v/vt", "v//vn" or "v/vt/vn": only v is used.
absl::StatusOr<SurfaceWork::Vertex> Corner(const TextReader& obj, std::size_t i,
                                           std::size_t count) {
  const std::string_view text = obj.token(i);
  std::int64_t index = 0;
  if (!ParseInt64(text.substr(0, text.find('/')), &index) || index == 0) {
    return obj.Error(
        Concat("no index of a vertex, which is 1 or more, or negative: ", Quoted(text)));
  }
  const auto n = static_cast<std::int64_t>(count);
  const std::int64_t from_zero = index > 0 ? index - 1 : n + index;
  if (from_zero < 0 || from_zero >= n) {
    return obj.Error(Concat("vertex ", index, " does not exist: ", n, n == 1 ? " stands" : " stand",
                            " above this line"));
  }
  return static_cast<SurfaceWork::Vertex>(from_zero);
}

absl::StatusOr<SurfaceWork::Ring> Corners(const TextReader& obj, const SurfaceWork& work) {
  SurfaceWork::Ring corners;
  for (std::size_t i = 1; i < obj.size(); ++i) {
    const auto corner = Corner(obj, i, work.point_count());
    if (!corner.ok()) return corner.status();
    corners.push_back(*corner);
  }
  return corners;
}

absl::Status AddPolyline(const SurfaceWork::Ring& chain, const TextReader& obj, SurfaceWork& work) {
  if (chain.size() < 2) return obj.Error("a line element has fewer than 2 vertices");
  for (std::size_t i = 1; i < chain.size(); ++i) {
    if (auto s = work.AddSegment(chain[i - 1], chain[i], obj.line()); !s.ok()) return s;
  }
  return absl::OkStatus();
}

absl::Status ReadVertex(const TextReader& obj, SurfaceWork& work) {
  const auto position = ReadPosition3(obj, 1, &work.digits());
  if (!position.ok()) return position.status();
  if (work.point_count() >= std::numeric_limits<std::uint32_t>::max() - 1) {
    return obj.Error("more than 2^32 - 2 vertices");
  }
  work.AddPoint(*position, obj.line());
  return absl::OkStatus();
}

absl::Status ReadElement(TextReader& obj, SurfaceWork& work) {
  const std::string_view kind = obj.token(0);
  if (kind != "v" && kind != "f" && kind != "l" && kind != "p") return absl::OkStatus();
  obj.JoinContinued();
  if (kind == "v") return ReadVertex(obj, work);
  absl::StatusOr<SurfaceWork::Ring> corners = Corners(obj, work);
  if (!corners.ok()) return corners.status();
  if (kind == "f") return work.AddFace({*std::move(corners)}, obj.line());
  if (kind == "l") return AddPolyline(*corners, obj, work);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<FileFeatures> ParseObjText(TextReader obj, FaceRules rules) {
  SurfaceWork work(obj.name(), 1, rules);
  while (obj.Next()) {
    if (auto s = ReadElement(obj, work); !s.ok()) return s;
  }
  return work.Take();
}

absl::StatusOr<FileFeatures> ReadObjFile(const std::string& path, FaceRules rules) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseObjText(*std::move(reader), rules);
}

}  // namespace dynmesh::io
