// A journal that several servers use at once, its *nodes*. Each mesh has at most one owner among
// them, with a lease that the node renews. A mesh can be claimed when its lease has run out or was
// given up. The lease is for progress; which node can write is decided by the epoch alone
// (journal.h, invariant 6).
//
// Calls block until the database answered. Errors: UNAVAILABLE. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_SHARED_JOURNAL_H_
#define DYNMESH_SERVER_JOURNAL_SHARED_JOURNAL_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

class SharedJournal {
 public:
  // A mesh as it is in the journal, and its owner.
  struct Place {
    Journal::Mesh mesh;
    std::uint64_t revision = 0;
    bool is_mine = false;  // this node claimed it last
    std::string address;   // of the owner, for clients; empty: not known
    std::int64_t epoch = 0;
    absl::Duration left;  // until the lease ends; at most 0: any node may claim it
  };

  virtual ~SharedJournal() = default;

  // How long a lease is.
  virtual absl::Duration lease() const = 0;
  // Says that the node is there, at `address`, and renews its leases. Returns the meshes that it
  // has, by key. Safe to repeat.
  virtual absl::StatusOr<std::vector<Journal::Key>> Renew(const std::string& address) = 0;
  // After the last append: other nodes may claim its meshes at once.
  virtual absl::Status GiveUp() = 0;
  // The addresses of the nodes that renewed within a lease.
  virtual absl::StatusOr<std::vector<std::string>> LiveNodes() = 0;
  // NOT_FOUND if there is no such mesh.
  virtual absl::StatusOr<Place> Locate(const std::string& id) = 0;
  // At most `limit` meshes with ids > `after`, by id.
  virtual absl::StatusOr<std::vector<Place>> LocateAll(const std::string& after,
                                                       std::size_t limit) = 0;
  // The epoch in which this node has the mesh; 0: it has not.
  virtual std::int64_t EpochOf(Journal::Key mesh) = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SHARED_JOURNAL_H_
