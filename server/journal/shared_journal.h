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
  struct Located {
    Journal::Mesh mesh;
    std::uint64_t revision = 0;
    bool is_mine = false;  // this node claimed it last
    std::string address;   // of the owner, for clients; empty: not known
    std::int64_t epoch = 0;
    absl::Duration left;  // until the lease ends; at most 0: any node may claim it
    // Of Locate only: the addresses of the live nodes that follow it, in order.
    std::vector<std::string> followers;
  };
  // Where a follower of a mesh is: it has all up to here.
  struct Position {
    Journal::Key mesh = 0;
    std::uint64_t revision = 0;
    std::int64_t answers = 0;  // number of the last request
  };
  // A mesh, and what follows a position.
  struct Tail {
    Journal::Key mesh = 0;
    bool exists = false;  // false: it was deleted; nothing else is set
    std::uint64_t head = 0;
    std::int64_t answers = 0;    // of the last of `requests`, or of the mesh
    std::uint64_t snapshot = 0;  // revision of the newest snapshot
    std::uint64_t snapshot_bytes = 0;
    bool is_mine = false, is_free = false;  // as of Located; free: any node may claim it
    std::string address;
    std::int64_t epoch = 0;
    std::vector<Journal::Entry> entries;  // the next ones; not all if they are many
    std::vector<Journal::Request> requests;
    // DATA_LOSS: a row is damaged. OUT_OF_RANGE: what follows is not there any more.
    absl::Status damage;
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
  virtual absl::StatusOr<Located> Locate(const std::string& id) = 0;
  // At most `limit` meshes with ids > `after`, by id.
  virtual absl::StatusOr<std::vector<Located>> LocateAll(const std::string& after,
                                                         std::size_t limit) = 0;
  // The epoch in which this node has the mesh; 0: it has not.
  virtual std::int64_t EpochOf(Journal::Key mesh) = 0;

  // What came after the positions, of different meshes, by key. Needs no claim. At one time as
  // many entries as fit into some megabytes a mesh, or one.
  virtual absl::StatusOr<std::vector<Tail>> ReadTails(const std::vector<Position>& positions) = 0;
  // The nodes at these addresses, and no others, are to follow a mesh that this node has.
  struct Wish {
    Journal::Key mesh = 0;
    std::vector<std::string> addresses;
  };
  // Asks the nodes that are live. Safe to repeat: what was asked before costs no write.
  virtual absl::Status AskToFollow(const std::vector<Wish>& wishes) = 0;
  // The ids of the meshes that this node is asked to follow.
  virtual absl::StatusOr<std::vector<std::string>> AskedToFollow() = 0;
  // Says that this node follows the mesh, or does not any more. Safe to repeat.
  virtual absl::Status SetFollows(Journal::Key mesh, bool follows) = 0;
  // Makes the node at `address` the owner of this node's mesh, with the next epoch, which is
  // returned, and a lease. To be called after the last append. FAILED_PRECONDITION: there is no
  // such node, or the mesh is not this node's any more.
  virtual absl::StatusOr<std::int64_t> HandOver(Journal::Key mesh, const std::string& address) = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SHARED_JOURNAL_H_
