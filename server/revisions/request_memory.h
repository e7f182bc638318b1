// What became of the last batches that carried a request_id, so that a retry is
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

// 128 bits that two different batches will not share by accident. Journals keep them: how they are
// made never changes.
struct Fingerprint {
  std::uint64_t a = 0, b = 0;
  friend bool operator==(const Fingerprint&, const Fingerprint&) = default;
};
Fingerprint FingerprintOf(const EditBatch& batch);
// Of going back to a revision, whatever edits that takes. No batch has it.
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

  // Null if the id is unknown or forgotten. Valid until the next Remember.
  const Entry* Find(absl::string_view request_id) const;
  // The id must be unknown. Forgets the oldest if there are too many.
  void Remember(std::string request_id, const Entry& entry);
  std::size_t size() const { return order_.size(); }

 private:
  const std::size_t capacity_;
  absl::flat_hash_map<std::string, Entry> entries_;
  std::deque<std::string> order_;  // oldest first
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_REVISIONS_REQUEST_MEMORY_H_
