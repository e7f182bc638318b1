// The schemas that a store of journals may have, a file of SQLite or a database of PostgreSQL: the
// tables of the first, and a step from each to the next.
#ifndef DYNMESH_SERVER_JOURNAL_SCHEMAS_H_
#define DYNMESH_SERVER_JOURNAL_SCHEMAS_H_

#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"

namespace dynmesh::server {

struct Schemas {
  int first;                           // the oldest that is read
  const char* tables;                  // makes it
  std::span<const char* const> steps;  // steps[n] leads from schema first + n to the next
  const char* store;                   // what has the tables, in messages: "journal"

  int present() const { return first + static_cast<int>(steps.size()); }
};

// FAILED_PRECONDITION for a newer schema than the present, and for one before the first. 0: there
// are no tables yet, which is good.
absl::Status CheckSchema(std::int64_t schema, const Schemas& schemas);

// The SQL that leads from `schema` to the present one; from 0 it makes the tables, too. REQUIRES:
// CheckSchema.
std::string StepsFrom(std::int64_t schema, const Schemas& schemas);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SCHEMAS_H_
