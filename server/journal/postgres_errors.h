// What an error of PostgreSQL means for a statement that may have changed something. Pure
// functions, thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_ERRORS_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_ERRORS_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server::postgres {

// A failed statement. If `unknown`, it may have been executed and committed: then the status is
// UNAVAILABLE. Otherwise it had no effect and will have none.
struct Failure {
  absl::Status status;
  bool unknown = false;
};

// By the error code that the server sent (SQLSTATE, five characters) and its message. A server
// rolls back before it sends an ERROR. What ends the connection (FATAL, PANIC) may come after the
// commit. UNAVAILABLE if it may be temporary, or an operator can remedy it without harm to the
// data; the message then says how. DATA_LOSS for damage that the server found.
Failure FailureOf(absl::string_view sqlstate, absl::string_view message);

// For a connection that broke while a statement ran.
Failure ConnectionLost(absl::string_view message);

// For a connection that was not made: UNAVAILABLE.
absl::Status NotConnected(absl::string_view message);

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_ERRORS_H_
