// Between C and C++: errors, columns, and no exception across.
#ifndef DYNMESH_CLIENT_C_SUPPORT_H_
#define DYNMESH_CLIENT_C_SUPPORT_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/c/dynmesh.h"
#include "dynmesh/options.h"

namespace dynmesh::c {

// The code of `status`; describes it in `error` unless that is null.
int Report(const absl::Status& status, dynmesh_error* error) noexcept;

// Describes an error in `error` unless that is null; returns its code. Takes no memory.
int ReportText(int code, std::string_view text, dynmesh_error* error) noexcept;

// The code of the status that `f` returns. What it throws becomes one.
template <class F>
int Guarded(dynmesh_error* error, F f) noexcept {
  try {
    return Report(f(), error);
  } catch (const std::bad_alloc&) {
    return ReportText(DYNMESH_RESOURCE_EXHAUSTED, "memory ran out", error);
  } catch (const std::exception& e) {
    return ReportText(DYNMESH_INTERNAL, e.what(), error);
  } catch (...) {
    return ReportText(DYNMESH_INTERNAL, "an unknown exception", error);
  }
}

template <class T>
constexpr std::int32_t kTypeOf = std::is_same_v<T, double>          ? DYNMESH_F64
                                 : std::is_same_v<T, std::int32_t>  ? DYNMESH_I32
                                 : std::is_same_v<T, std::uint64_t> ? DYNMESH_U64
                                 : std::is_same_v<T, std::uint8_t>  ? DYNMESH_U8
                                                                    : DYNMESH_I64;

// A column of the library's: `width` values a row.
template <class T>
dynmesh_column ColumnOf(std::span<const T> values, std::size_t width = 1) {
  return {values.data(), values.size() / width, static_cast<std::ptrdiff_t>(width * sizeof(T)),
          static_cast<std::int32_t>(width), kTypeOf<T>};
}

inline bool IsAligned(const void* data, std::size_t bytes) {
  return reinterpret_cast<std::uintptr_t>(data) % bytes == 0;
}

// INVALID_ARGUMENT unless `column` has values of this type, of 8 bytes, and `least` to `most` of
// them a row, all at multiples of 8 bytes.
absl::Status CheckColumn(const dynmesh_column& column, const char* name, std::int32_t type,
                         std::int32_t least, std::int32_t most);

// The first value of row `i` of a column that CheckColumn has accepted.
template <class T>
const T* RowOf(const dynmesh_column& column, std::size_t i) {
  return reinterpret_cast<const T*>(static_cast<const char*>(column.data) +
                                    static_cast<std::ptrdiff_t>(i) * column.stride);
}

// A column of one u64 a row. INVALID_ARGUMENT as CheckColumn.
absl::Status ReadIds(const dynmesh_column& column, const char* name,
                     std::vector<std::uint64_t>* ids);

// Writes `from` to the caller's structure of `size` bytes: no more than these. Bytes of members
// that are not known here become 0.
template <class S>
void Fill(const S& from, S* to, std::size_t size) {
  std::memset(static_cast<void*>(to), 0, size);
  std::memcpy(static_cast<void*>(to), &from, std::min(size, sizeof(S)));
  if (size >= sizeof(size)) std::memcpy(static_cast<void*>(to), &size, sizeof(size));
}

// Reads the caller's structure, which has `size` bytes by its first member, over the defaults in
// `to`. INVALID_ARGUMENT unless it has a member.
template <class S>
absl::Status ReadStructure(const S* from, S* to) {
  if (from == nullptr) return absl::InvalidArgumentError("a structure is missing");
  if (from->size <= sizeof(from->size)) {
    return absl::InvalidArgumentError(
        "the structure's member `size` is too small: set it with a function dynmesh_default_...");
  }
  std::memcpy(static_cast<void*>(to), from, std::min(from->size, sizeof(S)));
  return absl::OkStatus();
}

// The defaults.
dynmesh_options DefaultOptions(std::int32_t dimension);
dynmesh_apply_options DefaultApplyOptions();
dynmesh_field DefaultField();
dynmesh_choice DefaultChoice();

// The options in the caller's structure. INVALID_ARGUMENT as ReadStructure.
absl::StatusOr<MeshOptions> OptionsOf(const dynmesh_options* options);
dynmesh_options OptionsFor(const MeshOptions& from);

}  // namespace dynmesh::c

#endif  // DYNMESH_CLIENT_C_SUPPORT_H_
