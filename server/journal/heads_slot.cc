#include "server/journal/heads_slot.h"

#include <algorithm>

#include "server/journal/row_sum.h"

namespace dynmesh::server::heads {
namespace {

// Before the content: the checksum of all after it, and an increasing sequence number.
constexpr std::size_t kSumBytes = 8, kContentAt = 16;
static_assert(kContentAt + kContentBytes == kSlotBytes);

std::uint64_t SumOfSlot(std::size_t offset, absl::string_view rest) {
  return static_cast<std::uint64_t>(RowSumOf(static_cast<std::int64_t>(offset), rest));
}

}  // namespace

std::size_t OffsetOf(std::size_t slot, int copy) {
  const std::size_t block = 2 * (slot / kSlotsInBlock) + static_cast<std::size_t>(copy);
  return block * kBlockBytes + slot % kSlotsInBlock * kSlotBytes;
}

void AddNumber(std::uint64_t number, std::string* out) {
  for (int shift = 0; shift < 64; shift += 8) out->push_back(static_cast<char>(number >> shift));
}

std::string EncodeSlot(std::size_t offset, std::uint64_t sequence, const std::string& content) {
  std::string rest;
  AddNumber(sequence, &rest);
  rest += content;
  rest.resize(kSlotBytes - kSumBytes);
  std::string bytes;
  AddNumber(SumOfSlot(offset, rest), &bytes);
  return bytes + rest;
}

std::optional<FoundSlot> FindSlot(std::size_t slot, const std::string& file) {
  FoundSlot found;
  bool torn = false;
  for (int copy = 0; copy < 2; ++copy) {
    const std::size_t at = OffsetOf(slot, copy);
    if (at + kSlotBytes > file.size()) continue;
    const absl::string_view all(file.data() + at, kSlotBytes);
    if (std::all_of(all.begin(), all.end(), [](char c) { return c == 0; })) continue;
    SlotReader reader(all);
    if (reader.Number() != SumOfSlot(at, all.substr(kSumBytes))) {
      torn = true;
      continue;
    }
    const std::uint64_t sequence = reader.Number();
    if (!found.blank && found.sequence > sequence) continue;
    found = {sequence, copy, std::string(all.substr(kContentAt)), false};
  }
  if (torn && found.blank) return std::nullopt;
  return found;
}

std::uint64_t SlotReader::Number() {
  std::uint64_t number = 0;
  for (std::size_t i = 8; i-- > 0;) number = number << 8 | static_cast<unsigned char>(left_[i]);
  left_.remove_prefix(8);
  return number;
}

std::string SlotReader::Bytes(std::size_t count) {
  std::string bytes(left_.substr(0, count));
  left_.remove_prefix(count);
  return bytes;
}

}  // namespace dynmesh::server::heads
