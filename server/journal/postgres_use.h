// Whether a database may be opened for a purpose, before anything in it is touched.
// Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_USE_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_USE_H_

#include "absl/status/status.h"
#include "server/journal/open_postgres.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

// On the only connection that the caller has. May wait two seconds for connections to end.
// NOT_FOUND if there are no tables and `options` make none; FAILED_PRECONDITION if it is to be
// exclusive and a server uses the database. A server is known by its leases, and by the name of its
// connections, unless its address gives another one.
absl::Status CheckUse(Session& session, const PostgresOptions& options);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_USE_H_
