// The address of a database, as an operator gives it. Pure functions, thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_TARGET_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_TARGET_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace dynmesh::server::postgres {

// True if `place` is the address of a database. libpq takes both schemes.
inline bool IsAddress(absl::string_view place) {
  return absl::StartsWith(place, "postgresql://") || absl::StartsWith(place, "postgres://");
}

struct Target {
  std::string conninfo;  // for the library: may have a password
  std::string name;      // for messages: postgresql://HOSTS/DATABASE
};

// Reads `url`, postgresql://[USER[:PASSWORD]@][HOST[:PORT],...]/DATABASE[?KEY=VALUE&...] with the
// keys of libpq. What it leaves out has libpq's defaults, but for these: a connection to a host is
// given up after 5 s, a silent one is noticed after about 10 s, and of several hosts the one that
// can write is taken. With a `lease` > 0 a silent one is noticed after half of it, if that is less,
// and a host is given up after a quarter of it, but not before 0.5 s and 2 s.
// INVALID_ARGUMENT if it is malformed; the message has no password.
absl::StatusOr<Target> ParseTarget(const std::string& url,
                                   absl::Duration lease = absl::ZeroDuration());

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_TARGET_H_
