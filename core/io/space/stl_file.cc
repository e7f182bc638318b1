#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/ascii.h"
#include "core/base/text.h"
#include "core/io/common/section_rows.h"
#include "core/io/space/surface_files.h"
#include "core/io/space/surface_work.h"

namespace dynmesh::io {

using text::Concat;
using text::Quoted;
namespace {

// A binary file: a header of 80 bytes, the number of triangles, and for each its normal, its
// corners, and two bytes of attributes. All numbers are little-endian.
constexpr std::size_t kHeader = 84;
constexpr std::size_t kTriangle = 50;

std::uint32_t Word(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes[at + i]);
  return word;
}

// ASCII at bytes 80 to 83 would be the count of a file of 7 GB and more: no file is both. Some
// programs write a few bytes more.
bool IsBinary(std::string_view bytes) {
  if (bytes.size() < kHeader) return false;
  const std::uint64_t size = std::uint64_t{Word(bytes, 80)} * kTriangle;
  const std::uint64_t found = bytes.size() - kHeader;
  return found >= size && found - size < kTriangle;
}

class Triangles {
 public:
  Triangles(const std::string& file, FaceRules rules)
      : file_(file), rules_(rules), work_(file, 1, rules) {}

  absl::Status Add(const std::array<std::array<double, 3>, 3>& corners,
                   const std::array<int, 3>& lines, int line) {
    SurfaceWork::Ring ring;
    for (std::size_t k = 0; k < 3; ++k) {
      if (work_.point_count() >= std::numeric_limits<std::uint32_t>::max() - 1) {
        return TextReader::ErrorAt(file_, line, "more than 2^32 - 2 points");
      }
      ring.push_back(PointAt(corners[k], lines[k]));
    }
    if (rules_ == FaceRules::kStrict &&
        (ring[0] == ring[1] || ring[1] == ring[2] || ring[2] == ring[0])) {
      return TextReader::ErrorAt(file_, line,
                                 "two corners of a triangle are at one place; leave it out");
    }
    return work_.AddFace({std::move(ring)}, line);
  }

  WrittenDigits& digits() { return work_.digits(); }
  FileFeatures Take() { return work_.Take(); }

 private:
  SurfaceWork::Vertex PointAt(std::array<double, 3> position, int line) {
    std::array<std::uint64_t, 3> bits{};
    for (std::size_t k = 0; k < 3; ++k) {
      position[k] += 0.0;  // -0 is 0
      bits[k] = std::bit_cast<std::uint64_t>(position[k]);
    }
    const auto next = static_cast<SurfaceWork::Vertex>(work_.point_count());
    const auto [it, fresh] = at_.try_emplace(bits, next);
    if (fresh) work_.AddPoint(position, line);
    return it->second;
  }

  std::string file_;
  FaceRules rules_;
  SurfaceWork work_;
  absl::flat_hash_map<std::array<std::uint64_t, 3>, SurfaceWork::Vertex> at_;
};

absl::StatusOr<FileFeatures> ParseBinary(const TextReader& stl, FaceRules rules) {
  const std::string_view bytes = stl.text();
  Triangles triangles(stl.name(), rules);
  int number = 0;
  for (std::size_t at = kHeader; at + kTriangle <= bytes.size(); at += kTriangle) {
    if (number == std::numeric_limits<int>::max()) return stl.Error("more than 2^31 - 1 triangles");
    ++number;
    std::array<std::array<double, 3>, 3> corners{};
    for (std::size_t i = 0; i < 9; ++i) {
      const auto value = std::bit_cast<float>(Word(bytes, at + 12 + 4 * i));
      if (!std::isfinite(value)) {
        return TextReader::ErrorAt(
            stl.name(), number,
            Concat("triangle ", number, " of the file has a coordinate that is not finite"));
      }
      corners[i / 3][i % 3] = double{value};
      triangles.digits().AddFloat(value);
    }
    if (auto s = triangles.Add(corners, {number, number, number}, number); !s.ok()) return s;
  }
  return triangles.Take();
}

// Does the line start with these words, in any case of letters?
bool Starts(const TextReader& stl, std::string_view word, std::string_view second = "") {
  const auto is = [&](std::size_t i, std::string_view expected) {
    return i < stl.size() && absl::AsciiStrToLower(std::string(stl.token(i))) == expected;
  };
  return is(0, word) && (second.empty() || is(1, second));
}

absl::Status Expect(TextReader& stl, std::string_view word, std::string_view second = "") {
  const std::string words = second.empty() ? std::string(word) : Concat(word, " ", second);
  if (!stl.Next()) return stl.Error(Concat("the file ends where '", words, "' has to be"));
  if (Starts(stl, word, second)) return absl::OkStatus();
  return stl.Error(Concat("'", words, "' expected here, found ", Quoted(stl.token(0))));
}

absl::Status ReadFacet(TextReader& stl, Triangles& triangles) {
  const int line = stl.line();
  if (auto s = Expect(stl, "outer", "loop"); !s.ok()) return s;
  std::array<std::array<double, 3>, 3> corners{};
  std::array<int, 3> lines{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (auto s = Expect(stl, "vertex"); !s.ok()) return s;
    const auto position = ReadPosition3(stl, 1, &triangles.digits());
    if (!position.ok()) return position.status();
    corners[k] = *position;
    lines[k] = stl.line();
  }
  if (auto s = Expect(stl, "endloop"); !s.ok()) return s;
  if (auto s = Expect(stl, "endfacet"); !s.ok()) return s;
  return triangles.Add(corners, lines, line);
}

absl::StatusOr<FileFeatures> ParseAscii(TextReader& stl, FaceRules rules) {
  Triangles triangles(stl.name(), rules);
  bool open = false;
  while (stl.Next()) {
    if (!open && Starts(stl, "solid")) {
      open = true;
    } else if (open && Starts(stl, "endsolid")) {
      open = false;
    } else if (open && Starts(stl, "facet")) {
      if (auto s = ReadFacet(stl, triangles); !s.ok()) return s;
    } else {
      return stl.Error(Concat(open ? "'facet' or 'endsolid'" : "'solid'", " expected here, found ",
                              Quoted(stl.token(0))));
    }
  }
  if (open) return stl.Error("the file ends before 'endsolid'");
  return triangles.Take();
}

}  // namespace

absl::StatusOr<FileFeatures> ParseStlText(TextReader stl, FaceRules rules) {
  const std::string_view bytes = stl.text();
  if (IsBinary(bytes)) return ParseBinary(stl, rules);
  if (absl::AsciiStrToLower(std::string(bytes.substr(0, 5))) == "solid")
    return ParseAscii(stl, rules);
  std::string message = "neither 'solid' nor a binary file";
  if (bytes.size() >= kHeader) {
    message +=
        Concat(": one of ", Word(bytes, 80), " triangles would have ",
               kHeader + kTriangle * std::uint64_t{Word(bytes, 80)}, " bytes, not ", bytes.size());
  }
  return stl.Error(message);
}

absl::StatusOr<FileFeatures> ReadStlFile(const std::string& path, FaceRules rules) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseStlText(*std::move(reader), rules);
}

}  // namespace dynmesh::io
