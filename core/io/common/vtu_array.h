// Arrays of VTK XML files: the byte count, then the values, as one base64 text.
#ifndef DYNMESH_CORE_IO_COMMON_VTU_ARRAY_H_
#define DYNMESH_CORE_IO_COMMON_VTU_ARRAY_H_

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "absl/strings/escaping.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"

namespace dynmesh::io {

static_assert(std::endian::native == std::endian::little, "the file says LittleEndian");

inline constexpr std::string_view kVtuBegin =
    "<?xml version=\"1.0\"?>\n"
    "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
    "header_type=\"UInt64\">\n"
    "  <UnstructuredGrid>\n";
inline constexpr std::string_view kVtuEnd = "  </UnstructuredGrid>\n</VTKFile>\n";

// One <DataArray>. The attributes `shape` give the number of values.
template <class T>
void WriteShapedArray(std::string_view type, std::string_view name, std::string_view shape,
                      const std::vector<T>& values, FileWriter& out) {
  const std::uint64_t bytes = values.size() * sizeof(T);
  std::string raw(sizeof(bytes) + bytes, '\0');
  std::memcpy(raw.data(), &bytes, sizeof(bytes));
  if (bytes != 0) std::memcpy(raw.data() + sizeof(bytes), values.data(), bytes);
  out << "        <DataArray type=\"" << type << "\" Name=\"" << name << "\" " << shape
      << " format=\"binary\">\n          " << absl::Base64Escape(raw) << "\n        </DataArray>\n";
}

template <class T>
void WriteArray(std::string_view type, std::string_view name, int components,
                const std::vector<T>& values, FileWriter& out) {
  const std::string shape = text::Concat("NumberOfComponents=\"", components, "\"");
  WriteShapedArray(type, name, shape, values, out);
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_VTU_ARRAY_H_
