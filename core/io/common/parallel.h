// Work on files by several threads. The result never depends on their number: blocks are written in
// order. With one thread, or little to do, none is started.
#ifndef DYNMESH_CORE_IO_COMMON_PARALLEL_H_
#define DYNMESH_CORE_IO_COMMON_PARALLEL_H_

#include <algorithm>
#include <cstddef>
#include <functional>

#include "core/io/common/file_writer.h"
#include "core/io/common/text_block.h"

namespace dynmesh::io {

// Calls work(i) for each i below `count`, each once, on up to `threads` threads, this one included.
// `work` must be safe to call on several at once. An exception of `work` is thrown here.
void ForEachBlock(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

// Calls make(i, text) for each i below `count`, as ForEachBlock, and writes the texts in the order
// of i. Memory: two texts a thread.
void WriteBlocks(std::size_t count, int threads, FileWriter& out,
                 const std::function<void(std::size_t, TextBlock&)>& make);

// Calls format(i, text) for each row i below `count`, and writes the texts in the order of rows.
template <class Format>
void WriteRows(std::size_t count, int threads, FileWriter& out, const Format& format) {
  constexpr std::size_t kRows = 4096;  // a block: a few hundred kilobytes
  const auto make = [&](std::size_t block, TextBlock& text) {
    const std::size_t end = std::min((block + 1) * kRows, count);
    for (std::size_t i = block * kRows; i < end; ++i) format(i, text);
  };
  WriteBlocks((count + kRows - 1) / kRows, threads, out, make);
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_PARALLEL_H_
