// The slots of heads_file.h as bytes: where a slot's two copies stand, how they are checked, which
// one counts. Pure functions.
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

// In the file; `copy`: 0 or 1.
std::size_t OffsetOf(std::size_t slot, int copy);

void AddNumber(std::uint64_t number, std::string* out);

// kSlotBytes, to be written there; `content` has at most kContentBytes.
std::string EncodeSlot(std::size_t offset, std::uint64_t sequence, const std::string& content);

// What a slot holds.
struct FoundSlot {
  std::uint64_t sequence = 0;
  int copy = 0;
  std::string content;  // kContentBytes
  bool blank = true;    // nothing was ever written
};

// The newer of its copies that are whole; nullopt if none is, though something was written. `file`:
// all bytes of it.
std::optional<FoundSlot> FindSlot(std::size_t slot, const std::string& file);

// Takes numbers and bytes off the front of content, of which there are enough.
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
