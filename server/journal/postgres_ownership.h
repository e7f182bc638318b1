// The owner of a mesh in PostgreSQL, and the end of an append whose outcome is unknown.
//
// A mesh's row has an owner and an epoch. A claim changes both; every statement that changes the
// mesh compares the epoch. So an earlier owner cannot write, whatever it believes and however late
// its statement arrives.
//
// A resolution is a claim by the owner itself. It waits for a transaction that is still under way,
// stops one that arrives later, and reads what the row has come to. With synchronous standbys it is
// confirmed after all that was committed before it: so its answer is as durable as that of an
// append. Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_OWNERSHIP_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_OWNERSHIP_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

// What an owner believes of its mesh; true as long as it is the owner.
struct Belief {
  std::int64_t epoch = 0;
  std::int64_t head = 0;     // last revision
  std::int64_t answers = 0;  // number of the last request
};

struct Claimed {
  absl::Status status;   // NOT_FOUND for a mesh that does not exist
  bool unknown = false;  // to be repeated on another connection
  Belief belief;
};

// Makes `owner`, a name that no other journal object has, the owner of the mesh.
Claimed ClaimMesh(Session& session, std::int64_t mesh, const std::string& owner);

// Claims the mesh again if it still is `owner`'s. ABORTED if it is not.
Claimed ClaimAgain(Session& session, std::int64_t mesh, const std::string& owner);

// Why a statement with that belief found no row. NOT_FOUND: the mesh was deleted. ABORTED: another
// owner has it. DATA_LOSS: it is the owner's, and has an earlier state than was acknowledged.
absl::Status WhyRefused(Session& session, std::int64_t mesh, const std::string& owner,
                        const Belief& belief);

// DATA_LOSS: the owner's mesh is as `found`, not as was acknowledged.
absl::Status SetBack(const Belief& found, const Belief& belief);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_OWNERSHIP_H_
