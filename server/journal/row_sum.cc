#include "server/journal/row_sum.h"

#include <bit>
#include <cstddef>
#include <cstring>

#include "core/base/mix.h"

namespace dynmesh::server {
namespace {

// The next `count` <= 8 bytes in little-endian order on every machine.
std::uint64_t WordAt(const char* bytes, std::size_t count) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, count);
  return std::endian::native == std::endian::little ? word : __builtin_bswap64(word);
}

}  // namespace

RowSum& RowSum::Add(std::int64_t number) {
  state_ = MixBits(state_ + static_cast<std::uint64_t>(number));
  return *this;
}

RowSum& RowSum::Add(absl::string_view text) {
  Add(static_cast<std::int64_t>(text.size()));
  std::size_t at = 0;
  for (; at + 8 <= text.size(); at += 8) state_ = MixBits(state_ + WordAt(text.data() + at, 8));
  if (at < text.size()) state_ = MixBits(state_ + WordAt(text.data() + at, text.size() - at));
  return *this;
}

}  // namespace dynmesh::server
