#include "core/io/common/section_rows.h"

#include <algorithm>
#include <string>
#include <string_view>

#include "core/base/text.h"

namespace dynmesh::io {

using text::Concat;

std::size_t Reserve(std::uint64_t count, const TextReader& reader) {
  return static_cast<std::size_t>(std::min<std::uint64_t>(count, reader.text_size() / 4 + 1));
}

absl::StatusOr<std::uint64_t> HeaderValue(const TextReader& reader, std::size_t i, const char* what,
                                          std::uint64_t otherwise) {
  if (i >= reader.size()) return otherwise;
  return reader.Uint64(i, what);
}

absl::Status NextRow(TextReader& reader, const char* what, std::uint64_t row, std::uint64_t count) {
  if (reader.Next()) return absl::OkStatus();
  return reader.Error(Concat("the file ends after ", row, " of ", count, " ", what, " rows"));
}

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
                                          std::uint64_t base, std::size_t count) {
  absl::StatusOr<std::uint64_t> number = reader.Uint64(i, "vertex number");
  if (!number.ok()) return number.status();
  const std::uint64_t index = *number - base;  // 0 with base 1 wraps round: too large
  if (index >= count) {
    if (count == 0) {
      return reader.Error(Concat("vertex ", *number, " does not exist: there is none"));
    }
    return reader.Error(Concat("vertex ", *number, " does not exist: they run from ", base, " to ",
                               base + count - 1));
  }
  return static_cast<std::uint32_t>(index);
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

absl::StatusOr<std::array<double, 3>> ReadPosition3(const TextReader& reader, std::size_t i,
                                                    WrittenDigits* digits) {
  std::array<double, 3> position{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = reader.Double(i + k, std::string_view("xyz").substr(k, 1));
    if (!value.ok()) return value.status();
    position[k] = *value;
    if (digits != nullptr) digits->Add(reader.token(i + k), *value);
  }
  return position;
}

}  // namespace dynmesh::io
