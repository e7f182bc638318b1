// Records of a journal. A byte selects the kind. A record that decodes must encode to the same
// bytes; one that does not must be reported as damage.
#include <string>

#include "proto/codec/journal_codec.h"
#include "tests/fuzz/quiet.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

std::string CheckError(const absl::Status& status) {
  if (!absl::IsDataLoss(status)) return "damage is called something else: " + status.ToString();
  return status.message().empty() ? "a refusal without a message" : "";
}

// `first` was decoded from bytes; `Encode` and `Decode` are applied again. Compared as bytes, since
// NaN equals nothing, not even itself.
template <typename T, typename Encode, typename Decode>
std::string CheckRound(const absl::StatusOr<T>& first, Encode encode, Decode decode) {
  if (!first.ok()) return CheckError(first.status());
  const std::string written = encode(*first);
  const auto again = decode(written);
  if (!again.ok()) return "what was written is not read: " + again.status().ToString();
  return encode(*again) == written ? "" : "what was written is read as something else";
}

// What reads the hash alone reads the same.
std::string CheckHash(const std::string& bytes, const absl::StatusOr<codec::JournalEntry>& whole) {
  const auto hash = codec::DecodeJournalHash(bytes);
  if (!hash.ok() && whole.ok()) return "no hash in a record: " + hash.status().ToString();
  if (!hash.ok()) return CheckError(hash.status());
  return !whole.ok() || *hash == whole->hash ? "" : "another hash";
}

std::string CheckSnapshot(const std::string& bytes, int dimension) {
  codec::JournalEntry entry;
  const absl::Status status = codec::DecodeJournalSnapshot(bytes, dimension, &entry);
  const std::string other =
      CheckHash(bytes, status.ok() ? absl::StatusOr<codec::JournalEntry>(entry) : status);
  if (!other.empty()) return other;
  if (!status.ok()) return CheckError(status);
  const auto encode = [dimension](const codec::JournalEntry& e) {
    std::vector<Feature> features;
    for (const Edit& edit : e.edits) features.push_back(edit.feature);
    std::string all;
    for (const std::string& p : codec::EncodeJournalSnapshot(features, e.hash, dimension, e.bits)) {
      all += p;
    }
    return all;
  };
  // Parts that follow each other are, as messages, one.
  return CheckRound(absl::StatusOr<codec::JournalEntry>(entry), encode,
                    [dimension](const std::string& b) -> absl::StatusOr<codec::JournalEntry> {
                      codec::JournalEntry again;
                      absl::Status s = codec::DecodeJournalSnapshot(b, dimension, &again);
                      if (!s.ok()) return s;
                      return again;
                    });
}

}  // namespace

std::string FuzzJournal(std::string_view bytes) {
  BeQuiet();
  if (bytes.empty()) return "";
  const int kind = static_cast<unsigned char>(bytes[0]);
  const int dimension = kind % 2 == 0 ? 2 : 3;
  const std::string body(bytes.substr(1));
  switch (kind / 2 % 4) {
    case 0:
      if (const std::string other = CheckHash(body, codec::DecodeJournalEntry(body, dimension));
          !other.empty()) {
        return other;
      }
      return CheckRound(
          codec::DecodeJournalEntry(body, dimension),
          [&](const codec::JournalEntry& e) {
            return codec::EncodeJournalEntry(e.edits, e.hash, dimension, e.bits);
          },
          [&](const std::string& b) { return codec::DecodeJournalEntry(b, dimension); });
    case 1:
      return CheckSnapshot(body, dimension);
    case 2:
      return CheckRound(codec::DecodeJournalAnswer(body), &codec::EncodeJournalAnswer,
                        &codec::DecodeJournalAnswer);
    default:
      return CheckRound(codec::DecodeJournalMesh(body), &codec::EncodeJournalMesh,
                        &codec::DecodeJournalMesh);
  }
}

}  // namespace dynmesh::fuzz
