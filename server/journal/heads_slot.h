// The byte format of the slots of heads_file.h: the positions of a slot's two copies, their check,
// and the choice between them. Pure functions.
#ifndef DYNMESH_SERVER_JOURNAL_HEADS_SLOT_H_
#define DYNMESH_SERVER_JOURNAL_HEADS_SLOT_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace dynmesh::server::heads {

inline constexpr std::size_t kSlotBytes = 128, kSlotsInBlock = 32, kBlockBytes = 4'096;
inline constexpr std::size_t kContentBytes = 112;

// Position in the file; `copy`: 0 or 1.
std::size_t OffsetOf(std::size_t slot, int copy);

void AddNumber(std::uint64_t number, std::string* out);

// The kSlotBytes to write at `offset`; `content` has at most kContentBytes.
std::string EncodeSlot(std::size_t offset, std::uint64_t sequence, const std::string& content);

// The content of a slot.
struct FoundSlot {
  std::uint64_t sequence = 0;
  int copy = 0;
  std::string content;  // kContentBytes
  bool blank = true;    // never written
};

// The newer valid copy of the slot; nullopt if none is valid although something was written.
// `file`: all bytes of the file.
std::optional<FoundSlot> FindSlot(std::size_t slot, const std::string& file);

// Reads numbers and bytes from the front of a content. The content must have enough bytes.
class SlotReader {
 public:
  explicit SlotReader(absl::string_view bytes) : left_(bytes) {}
  std::uint64_t Number();
  std::int64_t Signed() { return static_cast<std::int64_t>(Number()); }
  std::string Bytes(std::size_t count);
  std::uint8_t Byte() { return static_cast<std::uint8_t>(Bytes(1)[0]); }

 private:
  absl::string_view left_;
};

}  // namespace dynmesh::server::heads

#endif  // DYNMESH_SERVER_JOURNAL_HEADS_SLOT_H_
