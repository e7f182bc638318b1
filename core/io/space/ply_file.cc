#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/io/common/section_rows.h"
#include "core/io/space/surface_files.h"
#include "core/io/space/surface_work.h"

namespace dynmesh::io {

using text::Concat;
using text::Quoted;
namespace {

struct Scalar {
  enum class Kind : std::uint8_t { kSigned, kUnsigned, kFloat };
  Kind kind = Kind::kFloat;
  std::size_t bytes = 4;
};

std::optional<Scalar> ScalarOf(std::string_view name) {
  using enum Scalar::Kind;
  struct Row {
    std::string_view old_name, name;
    Scalar scalar;
  };
  constexpr std::array<Row, 8> kRows = {{{"char", "int8", {kSigned, 1}},
                                         {"uchar", "uint8", {kUnsigned, 1}},
                                         {"short", "int16", {kSigned, 2}},
                                         {"ushort", "uint16", {kUnsigned, 2}},
                                         {"int", "int32", {kSigned, 4}},
                                         {"uint", "uint32", {kUnsigned, 4}},
                                         {"float", "float32", {kFloat, 4}},
                                         {"double", "float64", {kFloat, 8}}}};
  for (const Row& row : kRows) {
    if (name == row.old_name || name == row.name) return row.scalar;
  }
  return std::nullopt;
}

struct Property {
  std::string name;
  Scalar scalar;                // of a list: of its entries
  std::optional<Scalar> count;  // of a list: of its length
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Format : std::uint8_t { kAscii, kLittleEndian, kBigEndian };

struct PlyHeader {
  Format format = Format::kAscii;
  std::vector<Element> elements;
};

absl::Status ReadElement(const TextReader& ply, PlyHeader& header) {
  if (ply.size() != 3) return ply.Error("'element NAME COUNT' expected here");
  const auto count = ply.Uint64(2, "the number of elements");
  if (!count.ok()) return count.status();
  header.elements.push_back({std::string(ply.token(1)), *count, {}});
  return absl::OkStatus();
}

absl::Status ReadProperty(const TextReader& ply, PlyHeader& header) {
  if (header.elements.empty()) return ply.Error("a property stands before any element");
  const bool is_list = ply.size() > 1 && ply.token(1) == "list";
  if (ply.size() != (is_list ? 5 : 3)) {
    return ply.Error("'property TYPE NAME' or 'property list TYPE TYPE NAME' expected here");
  }
  Property property;
  property.name = std::string(ply.token(ply.size() - 1));
  for (std::size_t i = is_list ? 2 : 1; i + 1 < ply.size(); ++i) {
    const std::optional<Scalar> scalar = ScalarOf(ply.token(i));
    if (!scalar) return ply.Error(Concat(Quoted(ply.token(i)), " is no type of a property"));
    if (is_list && i == 2) {
      if (scalar->kind == Scalar::Kind::kFloat) return ply.Error("a list's length is no integer");
      property.count = scalar;
    } else {
      property.scalar = *scalar;
    }
  }
  header.elements.back().properties.push_back(std::move(property));
  return absl::OkStatus();
}

absl::StatusOr<Format> FormatOf(const TextReader& ply) {
  const std::string_view name = ply.size() > 1 ? ply.token(1) : "";
  if (ply.size() != 3 || ply.token(2) != "1.0") return ply.Error("'format NAME 1.0' expected here");
  if (name == "ascii") return Format::kAscii;
  if (name == "binary_little_endian") return Format::kLittleEndian;
  if (name == "binary_big_endian") return Format::kBigEndian;
  return ply.Error(Concat(Quoted(name), " is no format of a .ply"));
}

absl::StatusOr<PlyHeader> ReadPlyHeader(TextReader& ply) {
  if (!ply.Next() || ply.size() != 1 || ply.token(0) != "ply") {
    return ply.Error("a .ply file starts with a line 'ply'");
  }
  PlyHeader header;
  std::optional<Format> format;
  for (;;) {
    if (!ply.Next()) return ply.Error("the file ends before 'end_header'");
    const std::string_view word = ply.token(0);
    if (word == "end_header") break;
    if (word == "comment" || word == "obj_info") continue;
    absl::Status status;
    if (word == "format") {
      const absl::StatusOr<Format> found = FormatOf(ply);
      if (found.ok()) format = *found;
      status = found.status();
    } else if (word == "element") {
      status = ReadElement(ply, header);
    } else if (word == "property") {
      status = ReadProperty(ply, header);
    } else {
      status = ply.Error(Concat("no line of a header: ", Quoted(word)));
    }
    if (!status.ok()) return status;
  }
  if (!format) return ply.Error("the header has no line 'format'");
  header.format = *format;
  for (const Element& element : header.elements) {
    // A row of nothing would let a short file claim any number of rows.
    if (!element.properties.empty() || element.count == 0) continue;
    return ply.Error(Concat("element ", Quoted(element.name), " has no property"));
  }
  return header;
}

// The values of the body, row by row.
class Body {
 public:
  Body(TextReader& ply, Format format) : ply_(ply), format_(format) {}

  // Binary values begin after the header's last line. REQUIRES: the reader is at 'end_header'.
  void Start() {
    const std::string_view text = ply_.text();
    for (int line = 1; line <= ply_.line(); ++line) {
      const std::size_t end = text.find('\n', at_);
      at_ = end == std::string_view::npos ? text.size() : end + 1;
    }
  }

  absl::Status NextRow(const Element& element, std::uint64_t row) {
    element_ = &element;
    row_ = row;
    token_ = 0;
    if (format_ != Format::kAscii) return absl::OkStatus();
    return io::NextRow(ply_, element.name.c_str(), row, element.count);
  }

  absl::Status EndRow() const {
    if (format_ != Format::kAscii || token_ == ply_.size()) return absl::OkStatus();
    return Error(Concat("more values than properties, from ", Quoted(ply_.token(token_)), " on"));
  }

  absl::Status End() {
    if (format_ == Format::kAscii) return ExpectEnd(ply_);
    if (at_ == ply_.text().size()) return absl::OkStatus();
    return absl::InvalidArgumentError(
        Concat(ply_.name(), ": byte ", at_, ": more bytes than the header announces"));
  }

  // The value read last, if it is a coordinate.
  void AddDigits(const Scalar& scalar, double value, WrittenDigits& digits) const {
    if (format_ == Format::kAscii) {
      digits.Add(ply_.token(token_ - 1), value);
    } else if (scalar.kind == Scalar::Kind::kFloat && scalar.bytes == 4) {
      digits.AddFloat(static_cast<float>(value));
    } else {
      digits.AddDouble(value);
    }
  }

  absl::StatusOr<double> Value(const Scalar& scalar) {
    return format_ == Format::kAscii ? TextValue(scalar) : BinaryValue(scalar);
  }

  // Of a binary file, rows are counted from 1, as triangles of a binary .stl.
  int line() const {
    if (format_ == Format::kAscii) return ply_.line();
    constexpr std::uint64_t kMost = std::numeric_limits<int>::max();
    return static_cast<int>(std::min(row_ + 1, kMost));
  }

  absl::Status Error(const std::string& message) const {
    if (format_ == Format::kAscii) return ply_.Error(message);
    return absl::InvalidArgumentError(
        Concat(ply_.name(), ": byte ", at_, ", ", element_->name, " ", row_, ": ", message));
  }

 private:
  absl::StatusOr<double> TextValue(const Scalar& scalar) {
    if (token_ == ply_.size()) return Error("the line has fewer values than properties");
    if (scalar.kind == Scalar::Kind::kFloat) return ply_.Double(token_++, "a value");
    std::int64_t value = 0;
    if (!ParseInt64(ply_.token(token_), &value)) {
      return Error(Concat("no integer: ", Quoted(ply_.token(token_))));
    }
    ++token_;
    return static_cast<double>(value);
  }

  absl::StatusOr<double> BinaryValue(const Scalar& scalar) {
    const std::string_view text = ply_.text();
    if (text.size() - at_ < scalar.bytes) return Error("the file ends here");
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < scalar.bytes; ++i) {
      const std::size_t from = format_ == Format::kBigEndian ? i : scalar.bytes - 1 - i;
      bits = bits << 8 | static_cast<unsigned char>(text[at_ + from]);
    }
    at_ += scalar.bytes;
    switch (scalar.kind) {
      case Scalar::Kind::kUnsigned:
        return static_cast<double>(bits);
      case Scalar::Kind::kSigned: {
        const std::size_t unused = 64 - 8 * scalar.bytes;
        return static_cast<double>(static_cast<std::int64_t>(bits << unused) >> unused);
      }
      case Scalar::Kind::kFloat:
        break;
    }
    return scalar.bytes == 8 ? std::bit_cast<double>(bits)
                             : double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))};
  }

  TextReader& ply_;
  const Format format_;
  const Element* element_ = nullptr;
  std::uint64_t row_ = 0;
  std::size_t token_ = 0;
  std::size_t at_ = 0;
};

std::optional<std::size_t> Find(const Element& element, std::string_view name, bool is_list) {
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const Property& property = element.properties[i];
    if (property.name == name && property.count.has_value() == is_list) return i;
  }
  return std::nullopt;
}

class PlyParser {
 public:
  PlyParser(TextReader& ply, const PlyHeader& header, FaceRules rules)
      : ply_(ply), header_(header), body_(ply, header.format), work_(ply.name(), 0, rules) {}

  absl::StatusOr<FileFeatures> Run() {
    body_.Start();
    for (const Element& element : header_.elements) {
      absl::Status status;
      if (element.name == "vertex") {
        status = ReadVertices(element);
      } else if (element.name == "face") {
        status = ReadFaces(element);
      } else if (element.name == "edge") {
        status = ReadEdges(element);
      } else if (element.name == "tristrips" && element.count > 0) {
        status = ply_.Error("strips of triangles are not supported; write faces");
      } else {
        status = ReadRows(element, [] { return absl::OkStatus(); });
      }
      if (!status.ok()) return status;
    }
    if (auto s = body_.End(); !s.ok()) return s;
    return work_.Take();
  }

 private:
  // Calls use() after each row; its values are then in `single_` and `lists_`, by property.
  template <class Use>
  absl::Status ReadRows(const Element& element, Use use) {
    const std::size_t n = element.properties.size();
    single_.assign(n, 0);
    lists_.assign(n, {});
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (auto s = body_.NextRow(element, row); !s.ok()) return s;
      for (std::size_t i = 0; i < n; ++i) {
        const Property& property = element.properties[i];
        const auto value = body_.Value(property.count.value_or(property.scalar));
        if (!value.ok()) return value.status();
        single_[i] = *value;
        if (!property.count && i < is_coordinate_.size() && is_coordinate_[i]) {
          body_.AddDigits(property.scalar, *value, work_.digits());
        }
        if (!property.count) continue;
        if (*value < 0) return body_.Error("a list with a negative length");
        lists_[i].clear();
        for (double k = 0; k < single_[i]; ++k) {
          const auto entry = body_.Value(property.scalar);
          if (!entry.ok()) return entry.status();
          lists_[i].push_back(*entry);
        }
      }
      if (auto s = body_.EndRow(); !s.ok()) return s;
      if (auto s = use(); !s.ok()) return s;
    }
    return absl::OkStatus();
  }

  absl::Status ReadVertices(const Element& element) {
    std::array<std::size_t, 3> at{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string_view name = std::string_view("xyz").substr(k, 1);
      const auto found = Find(element, name, false);
      if (!found) return ply_.Error(Concat("vertices have no property ", Quoted(name)));
      at[k] = *found;
    }
    if (element.count >= std::numeric_limits<std::uint32_t>::max() - work_.point_count()) {
      return ply_.Error(Concat(element.count, " vertices are more than 2^32 - 2"));
    }
    is_coordinate_.assign(element.properties.size(), false);
    for (const std::size_t i : at) is_coordinate_[i] = true;
    const absl::Status read = ReadRows(element, [&]() -> absl::Status {
      const std::array<double, 3> position = {single_[at[0]], single_[at[1]], single_[at[2]]};
      for (const double x : position) {
        if (!std::isfinite(x)) return body_.Error("a vertex with a coordinate not finite");
      }
      work_.AddPoint(position, body_.line());
      return absl::OkStatus();
    });
    is_coordinate_.clear();
    return read;
  }

  absl::StatusOr<SurfaceWork::Vertex> VertexOf(double index) const {
    if (index >= 0 && index < static_cast<double>(work_.point_count()) &&
        index == std::floor(index)) {
      return static_cast<SurfaceWork::Vertex>(index);
    }
    return body_.Error(Concat("vertex ", index, " does not exist: ", work_.point_count(),
                              " stand before, numbered from 0"));
  }

  absl::Status ReadFaces(const Element& element) {
    auto found = Find(element, "vertex_indices", true);
    if (!found) found = Find(element, "vertex_index", true);
    if (!found) return ply_.Error("faces have no list 'vertex_indices'");
    return ReadRows(element, [&]() -> absl::Status {
      SurfaceWork::Ring ring;
      for (const double index : lists_[*found]) {
        const auto v = VertexOf(index);
        if (!v.ok()) return v.status();
        ring.push_back(*v);
      }
      return work_.AddFace({std::move(ring)}, body_.line());
    });
  }

  absl::Status ReadEdges(const Element& element) {
    const auto from = Find(element, "vertex1", false), to = Find(element, "vertex2", false);
    if (!from || !to) return ply_.Error("edges have no properties 'vertex1' and 'vertex2'");
    return ReadRows(element, [&]() -> absl::Status {
      const auto p = VertexOf(single_[*from]), q = VertexOf(single_[*to]);
      if (!p.ok()) return p.status();
      if (!q.ok()) return q.status();
      return work_.AddSegment(*p, *q, body_.line());
    });
  }

  TextReader& ply_;
  const PlyHeader& header_;
  Body body_;
  SurfaceWork work_;
  std::vector<double> single_;              // of the row, by property
  std::vector<std::vector<double>> lists_;  // the same
  std::vector<bool> is_coordinate_;         // the same; of vertices
};

}  // namespace

absl::StatusOr<FileFeatures> ParsePlyText(TextReader ply, FaceRules rules) {
  const absl::StatusOr<PlyHeader> header = ReadPlyHeader(ply);
  if (!header.ok()) return header.status();
  return PlyParser(ply, *header, rules).Run();
}

absl::StatusOr<FileFeatures> ReadPlyFile(const std::string& path, FaceRules rules) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParsePlyText(*std::move(reader), rules);
}

}  // namespace dynmesh::io
