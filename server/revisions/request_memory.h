// Idempotency cache: the outcomes of the last batches with a request_id, so that a retry is
// answered and not applied again. Thread-compatible.
#ifndef DYNMESH_SERVER_REVISIONS_REQUEST_MEMORY_H_
#define DYNMESH_SERVER_REVISIONS_REQUEST_MEMORY_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/string_view.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::server {

// 128 bits; two different batches do not share them by chance. Journals store them, so the function
// never changes.
struct Fingerprint {
  std::uint64_t a = 0, b = 0;
  friend bool operator==(const Fingerprint&, const Fingerprint&) = default;
};
Fingerprint FingerprintOf(const EditBatch& batch);
// For a revert to `revision`, whatever edits it takes. No batch has it.
Fingerprint FingerprintOfRevert(std::uint64_t revision);

class RequestMemory {
 public:
  struct Entry {
    Fingerprint content;
    std::uint64_t from_revision = 0;
    std::uint64_t to_revision = 0;
    MeshHash hash;
    WorkCounters work;
  };

  explicit RequestMemory(std::size_t capacity) : capacity_(capacity) {}

  // Null if the id is unknown or evicted. Valid until the next Remember.
  const Entry* Find(absl::string_view request_id) const;
  // `request_id` must be unknown. Evicts the oldest entry at the limit.
  void Remember(std::string request_id, const Entry& entry);
  std::size_t size() const { return order_.size(); }

 private:
  const std::size_t capacity_;
  absl::flat_hash_map<std::string, Entry> entries_;
  std::deque<std::string> order_;  // oldest first
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_REVISIONS_REQUEST_MEMORY_H_
