// Leases of meshes for several servers on one database: they say when a mesh may be claimed from a
// server that does not answer any more. Only the database's clock counts. A lease is for progress;
// which server can write is decided by the epoch alone (postgres_ownership.h).
//
// Additions to the schema, which a server without leases does not notice:
//   nodes               a row per server: id, the name that owns meshes; address, for clients;
//                       seen, when it renewed last
//   meshes.lease_until  -infinity: nothing is leased
//   followers           which nodes are asked to follow which meshes, and which do: is_warm. It
//                       counts for nodes that are live
//   meshes_by_owner     an index: a renewal costs as many rows as the server has meshes
// Each function but PrepareLeases is one statement, and safe to repeat. Errors: as Session::Run.
// Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_LEASES_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_LEASES_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/journal/postgres_ownership.h"
#include "server/journal/postgres_session.h"
#include "server/journal/shared_journal.h"

namespace dynmesh::server::postgres {

struct Node {
  std::string id;  // as the owner of meshes
  std::string address;
};

// Another server's hold on a mesh.
struct Holder {
  Node node;  // without an address if the node is not known
  std::int64_t epoch = 0;
  absl::Duration left;  // until the lease ends; > 0
};

// The end of ClaimFree. With status OK either the mesh is claimed, or `held` is true.
struct FreeClaim {
  absl::Status status;   // NOT_FOUND for a mesh that does not exist
  bool unknown = false;  // to be repeated on another connection
  bool held = false;
  Holder holder;  // if held
  Belief belief;  // if claimed
};

// Makes the additions if they are missing, after PrepareSchema. Several servers may start at once.
absl::Status PrepareLeases(Session& session);

// Says that the node is there, and renews all its leases for `ttl` from now on. Returns the meshes
// whose leases it renewed, by key. Forgets nodes that have not renewed for a day. A lease that ran
// out is renewed, too, if no other server has claimed the mesh; one that was given up is not.
absl::StatusOr<std::vector<std::int64_t>> RenewLeases(Session& session, const Node& node,
                                                      absl::Duration ttl);

// The nodes that renewed within the last `ttl`, by id.
absl::StatusOr<std::vector<Node>> LiveNodes(Session& session, absl::Duration ttl);

// Makes the node the owner of the mesh, with a new epoch and a lease of `ttl`, unless another one
// has a lease that has not run out. Of several claims at once one is granted.
//
// The lease counts from the sending at the earliest. A claim whose answer took longer than a tenth
// of `ttl`, as it waited for a lock, is made again: its lease may have run out, and the node would
// answer reads by its own last renewal, beside the next owner. UNAVAILABLE after many such claims.
FreeClaim ClaimFree(Session& session, std::int64_t mesh, const std::string& node,
                    absl::Duration ttl);

// The mesh `id` as `node` sees it. NOT_FOUND for one that does not exist. Of the nodes that follow
// it those are told that renewed within the last `ttl`.
absl::StatusOr<SharedJournal::Located> LocateMesh(Session& session, const std::string& id,
                                                  const std::string& node, absl::Duration ttl);
// At most `limit` meshes with ids > `after`, by id.
absl::StatusOr<std::vector<SharedJournal::Located>> LocateMeshes(Session& session,
                                                                 const std::string& after,
                                                                 std::size_t limit,
                                                                 const std::string& node);

// As SharedJournal's.
absl::Status AskToFollow(Session& session, const std::vector<SharedJournal::Wish>& wishes,
                         absl::Duration ttl);
absl::StatusOr<std::vector<std::string>> AskedToFollow(Session& session, const std::string& node);
// Says that the node follows the mesh, or does not, and is not asked to any more.
absl::Status SetFollows(Session& session, std::int64_t mesh, const std::string& node, bool follows);

// Where a mesh is claimed: by that node, in that epoch.
struct Hold {
  std::string node;
  std::int64_t epoch = 0;
};
// Makes the node at `address`, which renewed within `ttl`, the owner of a mesh, if it is held as
// `hold` says: with the next epoch, which is returned, and a lease of `ttl`. FAILED_PRECONDITION if
// there is no such node or the mesh is not held like that.
absl::StatusOr<std::int64_t> HandOver(Session& session, std::int64_t mesh, const Hold& hold,
                                      const std::string& address, absl::Duration ttl);

// For a drain, after the last append: other nodes may claim its meshes at once, and it does not
// count as live. Its epochs stay, so what it still has in flight is not refused before such a
// claim.
absl::Status GiveUpLeases(Session& session, const std::string& node);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_LEASES_H_
