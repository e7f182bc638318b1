// VTK's unstructured grids, `.vtu`.
#include <cmath>
#include <optional>

#include "core/io/elements/element_builder.h"
#include "core/io/elements/vtu_data.h"

namespace dynmesh::io {
namespace {

using text::Concat;
using text::Quoted;

struct CellType {
  std::int64_t type;
  std::size_t corners, nodes;
};
constexpr CellType kCells[] = {{1, 1, 1},  {3, 2, 2},  {5, 3, 3},  {10, 4, 4},
                               {21, 2, 3}, {22, 3, 6}, {24, 4, 10}};

class VtuReader {
 public:
  VtuReader(const std::string& name, std::string_view text)
      : name_(name), text_(text), builder_(name) {}

  absl::StatusOr<ElementMesh> Read() {
    absl::StatusOr<std::vector<XmlTag>> tags = ParseXmlTags(name_, text_);
    if (!tags.ok()) return tags.status();
    if (auto s = ReadTags(*tags); !s.ok()) return s;
    for (const auto& [part, is_there] :
         {std::pair("array in Points", points_ != nullptr),
          {"array 'connectivity' in Cells", connectivity_.has_value()},
          {"array 'offsets' in Cells", offsets_.has_value()},
          {"array 'types' in Cells", types_.has_value()}}) {
      if (is_there) continue;
      return TextReader::ErrorAt(name_, 1, Concat("no unstructured grid: there is no ", part));
    }
    if (auto s = AddVertices(); !s.ok()) return s;
    if (auto s = AddCells(); !s.ok()) return s;
    return builder_.Take();
  }

 private:
  absl::Status Error(const XmlTag& tag, std::string_view message) const {
    return TextReader::ErrorAt(name_, tag.line, message);
  }

  absl::Status ReadTags(const std::vector<XmlTag>& tags) {
    for (const XmlTag& tag : tags) {
      if (tag.name == "VTKFile") {
        if (auto s = ReadHead(tag); !s.ok()) return s;
      } else if (tag.name == "AppendedData") {
        if (tag.Get("encoding") != "base64") {
          return Error(tag, "appended data that are no base64 cannot be read: write them inline");
        }
        packing_.appended = tag.text;
        const std::size_t underscore = tag.text.find('_');
        if (underscore != std::string_view::npos) packing_.appended.remove_prefix(underscore + 1);
      }
    }
    std::string_view part;
    for (const XmlTag& tag : tags) {
      if (tag.name == "Piece") {
        if (has_piece_) return Error(tag, "a second Piece: write the grid as one");
        has_piece_ = true;
        if (!ParseUint64(tag.Get("NumberOfPoints"), &vertices_) ||
            !ParseUint64(tag.Get("NumberOfCells"), &cells_) || vertices_ >= 1u << 31 ||
            cells_ >= 1u << 31) {
          return Error(tag, "a Piece with no NumberOfPoints and NumberOfCells below 2^31");
        }
      } else if (tag.name == "DataArray" && has_piece_) {
        if (auto s = ReadArray(part, tag); !s.ok()) return s;
      } else if (tag.name == "Points" || tag.name == "Cells" || tag.name == "CellData" ||
                 tag.name == "PointData" || tag.name == "FieldData") {
        part = tag.name;
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadHead(const XmlTag& tag) {
    if (tag.Get("type") != "UnstructuredGrid") {
      return Error(tag, Concat("the type of the file is ", Quoted(tag.Get("type")),
                               ": only an UnstructuredGrid can be read"));
    }
    if (tag.Get("byte_order") == "BigEndian") return Error(tag, "big-endian data cannot be read");
    if (tag.Get("header_type") == "UInt64") packing_.count_bytes = 8;
    const std::string_view compressor = tag.Get("compressor");
    packing_.is_compressed = compressor == "vtkZLibDataCompressor";
    if (!compressor.empty() && !packing_.is_compressed) {
      return Error(tag, Concat("compressor ", Quoted(compressor), ": only zlib's can be read"));
    }
    return absl::OkStatus();
  }

  absl::Status ReadArray(std::string_view part, const XmlTag& tag) {
    const std::string_view name = tag.Get("Name");
    std::optional<VtuValues>* to = nullptr;
    std::uint64_t most = cells_;
    if (part == "Points") {
      points_ = &tag;
      most = 3 * vertices_;
      to = &coordinates_;
    } else if (part == "Cells" && name == "connectivity") {
      most = 27 * cells_;
      to = &connectivity_;
    } else if (part == "Cells" && name == "offsets") {
      to = &offsets_;
    } else if (part == "Cells" && name == "types") {
      to = &types_;
    } else if (part == "CellData" &&
               (name == "marker" || name == "medit:ref" || name == "gmsh:physical") &&
               (tag.Get("NumberOfComponents").empty() || tag.Get("NumberOfComponents") == "1")) {
      if (markers_ && name != "marker") return absl::OkStatus();
      to = &markers_;
    }
    if (to == nullptr) return absl::OkStatus();
    absl::StatusOr<VtuValues> values = ReadVtuValues(name_, tag, packing_, most);
    if (!values.ok()) return values.status();
    *to = *std::move(values);
    if (to == &connectivity_ || to == &offsets_ || to == &types_) {
      if ((*to)->wholes.size() != (*to)->reals.size()) {
        return Error(tag, Concat("array ", Quoted(name), " must be of whole numbers"));
      }
      cells_tag_ = &tag;
    }
    return absl::OkStatus();
  }

  absl::Status AddVertices() {
    if (coordinates_->reals.size() != 3 * vertices_) {
      return Error(*points_, Concat("Points has ", coordinates_->reals.size(),
                                    " values, not 3 for ", vertices_, " points"));
    }
    for (std::uint64_t i = 0; i < vertices_; ++i) {
      std::array<double, 3> position;
      for (std::size_t k = 0; k < 3; ++k) {
        position[k] = coordinates_->reals[3 * i + k];
        if (!std::isfinite(position[k])) {
          return Error(*points_, Concat("point ", i, " is not finite"));
        }
      }
      if (auto s = builder_.AddVertex(i, position, points_->line); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  absl::Status AddCells() {
    const XmlTag& tag = *cells_tag_;
    if (offsets_->wholes.size() != cells_ || types_->wholes.size() != cells_) {
      return Error(tag, Concat("offsets or types have not ", cells_, " values"));
    }
    std::int64_t begin = 0;
    for (std::uint64_t i = 0; i < cells_; ++i) {
      const std::int64_t end = offsets_->wholes[i];
      const CellType* type = nullptr;
      for (const CellType& known : kCells) {
        if (known.type == types_->wholes[i]) type = &known;
      }
      if (type == nullptr) {
        return Error(tag, Concat("cell ", i, " is of type ", types_->wholes[i],
                                 ": only points, lines, triangles and tetrahedra can be read"));
      }
      if (end < begin || end - begin != static_cast<std::int64_t>(type->nodes) ||
          end > static_cast<std::int64_t>(connectivity_->wholes.size())) {
        return Error(tag, Concat("cell ", i, " has not the number of points of its type"));
      }
      std::array<std::uint64_t, 4> corners{};
      for (std::size_t k = 0; k < type->corners; ++k) {
        corners[k] =
            static_cast<std::uint64_t>(connectivity_->wholes[static_cast<std::size_t>(begin) + k]);
      }
      const bool has_marker =
          markers_ && i < markers_->reals.size() && std::abs(markers_->reals[i]) < 0x1p62;
      const auto marker = has_marker ? static_cast<std::int64_t>(markers_->reals[i]) : 0;
      const auto first = std::span<const std::uint64_t>(corners).first(type->corners);
      if (auto s = builder_.AddElement(first, marker, tag.line); !s.ok()) return s;
      begin = end;
    }
    return absl::OkStatus();
  }

  const std::string& name_;
  const std::string_view text_;
  ElementBuilder builder_;
  VtuPacking packing_;
  bool has_piece_ = false;
  std::uint64_t vertices_ = 0, cells_ = 0;
  const XmlTag* points_ = nullptr;
  const XmlTag* cells_tag_ = nullptr;
  std::optional<VtuValues> coordinates_, connectivity_, offsets_, types_, markers_;
};

}  // namespace

absl::StatusOr<ElementMesh> ParseVtu(const std::string& name, const std::string& text) {
  return VtuReader(name, text).Read();
}

}  // namespace dynmesh::io
