// Arrays of VTK XML files: values compressed by zlib, in blocks, as base64.
#ifndef DYNMESH_CORE_IO_COMMON_VTU_ARRAY_H_
#define DYNMESH_CORE_IO_COMMON_VTU_ARRAY_H_

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/text.h"
#include "core/io/common/file_writer.h"

namespace dynmesh::io {

static_assert(std::endian::native == std::endian::little, "the file says LittleEndian");

inline constexpr std::string_view kVtuBegin =
    "<?xml version=\"1.0\"?>\n"
    "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
    "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n"
    "  <UnstructuredGrid>\n";
inline constexpr std::string_view kVtuEnd = "  </UnstructuredGrid>\n</VTKFile>\n";

// The base64 of VTK's header (counts and sizes of blocks), then that of the blocks, which up to
// `threads` threads compress at once.
std::string Compressed(std::string_view bytes, int threads);

template <class T>
std::string CompressedArray(const std::vector<T>& values, int threads) {
  return Compressed({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)},
                    threads);
}

// One <DataArray> of what CompressedArray has made. The attributes `shape` give the number of
// values.
void WriteCompressedArray(std::string_view type, std::string_view name, std::string_view shape,
                          std::string_view compressed, FileWriter& out);

template <class T>
void WriteShapedArray(std::string_view type, std::string_view name, std::string_view shape,
                      const std::vector<T>& values, FileWriter& out, int threads = 1) {
  WriteCompressedArray(type, name, shape, CompressedArray(values, threads), out);
}

template <class T>
void WriteArray(std::string_view type, std::string_view name, int components,
                const std::vector<T>& values, FileWriter& out, int threads = 1) {
  // One is the default. Said, it makes meshio read columns of one.
  const std::string shape =
      components == 1 ? "" : text::Concat("NumberOfComponents=\"", components, "\"");
  WriteShapedArray(type, name, shape, values, out, threads);
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_VTU_ARRAY_H_
