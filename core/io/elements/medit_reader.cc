// Medit's `.mesh`, ASCII.
#include <string_view>
#include <vector>

#include "core/io/elements/element_builder.h"
#include "core/io/elements/token_stream.h"

namespace dynmesh::io {
namespace {

using text::Concat;
using text::Quoted;

class MeditReader {
 public:
  explicit MeditReader(TextReader reader) : in_(std::move(reader)), builder_(in_.name()) {}

  absl::StatusOr<ElementMesh> Read() {
    if (!in_.Next() || in_.token() != "MeshVersionFormatted") {
      return in_.Error(
          "a Medit file must begin with MeshVersionFormatted; a binary one, .meshb, "
          "cannot be read");
    }
    if (auto s = in_.Skip(1, "the version"); !s.ok()) return s;
    while (in_.Next() && in_.token() != "End") {
      const std::string word(in_.token());
      if (auto s = ReadSection(word); !s.ok()) return s;
    }
    return builder_.Take();
  }

 private:
  absl::Status ReadSection(std::string_view word) {
    if (word == "Dimension") {
      const auto dimension = in_.Uint64("the dimension");
      if (!dimension.ok()) return dimension.status();
      if (*dimension != 2 && *dimension != 3) return in_.Error("the dimension must be 2 or 3");
      dimension_ = static_cast<std::size_t>(*dimension);
      return absl::OkStatus();
    }
    if (word == "Vertices") return ReadVertices();
    // By corners; and what is not read, with the numbers in a row.
    constexpr std::pair<std::string_view, std::size_t> kElements[] = {
        {"Edges", 2}, {"Triangles", 3}, {"Tetrahedra", 4}};
    for (const auto& [name, corners] : kElements) {
      if (word == name) return ReadElements(corners);
    }
    const std::pair<std::string_view, std::size_t> skipped_sections[] = {
        {"Corners", 1},          {"RequiredVertices", 1},  {"Ridges", 1},
        {"RequiredEdges", 1},    {"RequiredTriangles", 1}, {"RequiredTetrahedra", 1},
        {"NormalAtVertices", 2}, {"TangentAtVertices", 2}, {"Tangents", dimension_},
        {"Normals", dimension_}, {"ParallelEdges", 1},     {"ParallelTriangles", 1}};
    for (const auto& [name, width] : skipped_sections) {
      if (word != name) continue;
      const auto count = in_.Count("the number of rows");
      if (!count.ok()) return count.status();
      return in_.Skip(*count * width, Concat("the rows of ", name));
    }
    return in_.Error(Concat("section ", Quoted(word),
                            " cannot be read: only Vertices, Edges, Triangles and Tetrahedra"));
  }

  absl::Status ReadVertices() {
    const auto count = in_.Count("the number of vertices");
    if (!count.ok()) return count.status();
    if (dimension_ == 0) return in_.Error("Dimension must stand before Vertices");
    for (std::uint64_t i = 0; i < *count; ++i) {
      std::array<double, 3> position = {0, 0, 0};
      for (std::size_t k = 0; k < dimension_; ++k) {
        const auto value = in_.Double("a coordinate");
        if (!value.ok()) return value.status();
        position[k] = *value;
      }
      const int line = in_.line();
      const auto reference = in_.Int64("a vertex's reference");
      if (!reference.ok()) return reference.status();
      if (auto s = builder_.AddVertex(++vertices_, position, line); !s.ok()) return s;
      // References of vertices on curves are the curves': only corners have one that stays.
    }
    return absl::OkStatus();
  }

  absl::Status ReadElements(std::size_t corners) {
    const auto count = in_.Count("the number of elements");
    if (!count.ok()) return count.status();
    std::array<std::uint64_t, 4> vertices{};
    for (std::uint64_t i = 0; i < *count; ++i) {
      for (std::size_t k = 0; k < corners; ++k) {
        const auto vertex = in_.Uint64("a vertex of an element");
        if (!vertex.ok()) return vertex.status();
        vertices[k] = *vertex;
      }
      const int line = in_.line();
      const auto reference = in_.Int64("an element's reference");
      if (!reference.ok()) return reference.status();
      const auto first = std::span<const std::uint64_t>(vertices).first(corners);
      if (auto s = builder_.AddElement(first, *reference, line); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  TokenStream in_;
  ElementBuilder builder_;
  std::size_t dimension_ = 0;
  std::uint64_t vertices_ = 0;
};

}  // namespace

absl::StatusOr<ElementMesh> ParseMedit(TextReader reader) {
  return MeditReader(std::move(reader)).Read();
}

}  // namespace dynmesh::io
