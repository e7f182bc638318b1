// Parts of the sections of Triangle's and TetGen's files: a header with a count, then that many
// rows. Errors are the reader's: `file:line: what is wrong`.
#ifndef DYNMESH_CORE_IO_COMMON_SECTION_ROWS_H_
#define DYNMESH_CORE_IO_COMMON_SECTION_ROWS_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/common/text_reader.h"
#include "core/io/common/written_digits.h"

namespace dynmesh::io {

// Memory to reserve: at most for as many rows as a file of this size can have.
std::size_t Reserve(std::uint64_t count, const TextReader& reader);

// An optional header value.
absl::StatusOr<std::uint64_t> HeaderValue(const TextReader& reader, std::size_t i, const char* what,
                                          std::uint64_t otherwise);
// The count at the start of a header of at most `max_header` values.
absl::StatusOr<std::uint64_t> ReadCount(TextReader& reader, const char* what,
                                        std::size_t max_header);
// Do rows have a marker?
absl::StatusOr<bool> MarkerFlag(const TextReader& reader, std::size_t i);

// Goes to row `row` of `count`.
absl::Status NextRow(TextReader& reader, const char* what, std::uint64_t row, std::uint64_t count);
// Rows are numbered from a base, which reveals a lost or repeated line.
absl::Status CheckNumber(const TextReader& reader, const char* what, std::uint64_t expected);
absl::Status CheckWidth(const TextReader& reader, const char* what, std::size_t width);
// Markers are signed in these files; feature ids need all 64 bits.
absl::StatusOr<std::uint64_t> Marker(const TextReader& reader, std::size_t i);
// Token i is the number of one of `count` vertices, numbered from `base` on. Returns its index from
// 0.
absl::StatusOr<std::uint32_t> VertexIndex(const TextReader& reader, std::size_t i,
                                          std::uint64_t base, std::size_t count);
// The three coordinates from token i on; `digits`, if any, gets them.
absl::StatusOr<std::array<double, 3>> ReadPosition3(const TextReader& reader, std::size_t i,
                                                    WrittenDigits* digits = nullptr);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_SECTION_ROWS_H_
