#include "core/io/common/vtu_array.h"

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <new>

#include "absl/strings/escaping.h"
#include "core/io/common/parallel.h"

namespace dynmesh::io {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 20;

void AppendCount(std::uint64_t count, std::string& to) {
  to.append(reinterpret_cast<const char*>(&count), sizeof(count));
}

}  // namespace

std::string Compressed(std::string_view bytes, int threads) {
  std::vector<std::string> blocks((bytes.size() + kBlock - 1) / kBlock);
  ForEachBlock(blocks.size(), threads, [&](std::size_t i) {
    const std::string_view part = bytes.substr(i * kBlock, kBlock);
    uLongf size = compressBound(part.size());
    std::string& block = blocks[i];
    block.resize(size);
    // The buffer is large enough and the level valid: no error is left but lack of memory.
    if (compress2(reinterpret_cast<Bytef*>(block.data()), &size,
                  reinterpret_cast<const Bytef*>(part.data()), part.size(), Z_BEST_SPEED) != Z_OK) {
      throw std::bad_alloc();
    }
    block.resize(size);
  });
  std::string header, data;
  AppendCount(blocks.size(), header);
  AppendCount(kBlock, header);
  AppendCount(bytes.size() % kBlock, header);  // of the last block; 0 if it is whole
  for (const std::string& block : blocks) {
    AppendCount(block.size(), header);
    data += block;
  }
  return absl::Base64Escape(header) + absl::Base64Escape(data);
}

void WriteCompressedArray(std::string_view type, std::string_view name, std::string_view shape,
                          std::string_view compressed, FileWriter& out) {
  out << "        <DataArray type=\"" << type << "\" Name=\"" << name << "\" " << shape
      << (shape.empty() ? "" : " ") << "format=\"binary\">\n          " << compressed
      << "\n        </DataArray>\n";
}

}  // namespace dynmesh::io
