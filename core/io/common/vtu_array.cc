#include "core/io/common/vtu_array.h"

#include <zlib.h>

#include <algorithm>
#include <cstddef>

#include "absl/strings/escaping.h"

namespace dynmesh::io {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 20;

void AppendCount(std::uint64_t count, std::string& to) {
  to.append(reinterpret_cast<const char*>(&count), sizeof(count));
}

}  // namespace

void WriteCompressed(std::string_view bytes, FileWriter& out) {
  const std::size_t blocks = (bytes.size() + kBlock - 1) / kBlock;
  std::string header, data, block;
  AppendCount(blocks, header);
  AppendCount(kBlock, header);
  AppendCount(bytes.size() % kBlock, header);  // of the last block; 0 if it is whole
  for (std::size_t at = 0; at < bytes.size(); at += kBlock) {
    const std::string_view part = bytes.substr(at, kBlock);
    uLongf size = compressBound(part.size());
    block.resize(size);
    // The buffer is large enough and the level valid: no error is left but lack of memory.
    if (compress2(reinterpret_cast<Bytef*>(block.data()), &size,
                  reinterpret_cast<const Bytef*>(part.data()), part.size(), Z_BEST_SPEED) != Z_OK) {
      throw std::bad_alloc();
    }
    data.append(block, 0, size);
    AppendCount(size, header);
  }
  out << absl::Base64Escape(header) << absl::Base64Escape(data);
}

}  // namespace dynmesh::io
