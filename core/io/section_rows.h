// What the sections of Triangle's and TetGen's files are made of: a header with a count, then
// that many rows. Errors are the reader's: `file:line: what is wrong`.
#ifndef DYNMESH_CORE_IO_SECTION_ROWS_H_
#define DYNMESH_CORE_IO_SECTION_ROWS_H_

#include <array>
#include <cstddef>
#include <cstdint>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/text_reader.h"

namespace dynmesh::io {

// More rows than any file of this size holds make no claim on memory.
std::size_t Reserve(std::uint64_t count, const TextReader& reader);

// A header value that may be left out.
absl::StatusOr<std::uint64_t> HeaderValue(const TextReader& reader, std::size_t i, const char* what,
                                          std::uint64_t otherwise);
// The count that a header of at most `max_header` values starts with.
absl::StatusOr<std::uint64_t> ReadCount(TextReader& reader, const char* what,
                                        std::size_t max_header);
// Do rows have a marker?
absl::StatusOr<bool> MarkerFlag(const TextReader& reader, std::size_t i);

// Goes to row `row` of `count`.
absl::Status NextRow(TextReader& reader, const char* what, std::uint64_t row, std::uint64_t count);
// Rows count up from a base, so that a lost or doubled line is seen.
absl::Status CheckNumber(const TextReader& reader, const char* what, std::uint64_t expected);
absl::Status CheckWidth(const TextReader& reader, const char* what, std::size_t width);
// Markers are signed in these files; feature ids need all 64 bits.
absl::StatusOr<std::uint64_t> Marker(const TextReader& reader, std::size_t i);
// Token i names one of `count` vertices, which are numbered from `base` on: its index from 0.
absl::StatusOr<std::uint32_t> VertexIndex(const TextReader& reader, std::size_t i,
                                          std::uint64_t base, std::size_t count);
// The three coordinates from token i on.
absl::StatusOr<std::array<double, 3>> ReadPosition3(const TextReader& reader, std::size_t i);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SECTION_ROWS_H_
