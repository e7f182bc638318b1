// The statement that appends a group of batches to a mesh in PostgreSQL, or changes nothing: one
// round trip, and one transaction by itself. Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_APPEND_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_APPEND_H_

#include <cstdint>
#include <string>
#include <vector>

#include "server/journal/journal.h"
#include "server/journal/postgres_ownership.h"
#include "server/journal/postgres_session.h"

namespace dynmesh::server::postgres {

class GroupAppend {
 public:
  // For a mesh of which `belief` is known; the entries follow its head. Of the requests, the newest
  // `remembered` are kept, and up to a hundredth more. O(bytes): copies all.
  GroupAppend(Journal::Key mesh, const Belief& belief, const std::vector<Journal::Entry>& entries,
              const std::vector<Journal::Request>& requests, std::size_t remembered);

  // Appends if the mesh has that epoch, and still the believed head. No row: it has not, and
  // nothing was changed.
  Answer Run(Session& session, std::int64_t epoch) const;

  // What is believed after an append in that epoch.
  Belief After(std::int64_t epoch) const {
    return {epoch, before_.head + Count(entry_sums_), before_.answers + Count(request_sums_)};
  }
  const Belief& before() const { return before_; }

 private:
  static std::int64_t Count(const std::vector<std::int64_t>& sums) {
    return static_cast<std::int64_t>(sums.size());
  }

  const Journal::Key mesh_;
  const Belief before_;
  // All data in one string: a parameter of its own for each would be written as hexadecimal digits.
  std::string entries_, requests_;
  std::vector<std::int64_t> entry_sizes_, entry_sums_;
  std::vector<std::int64_t> id_sizes_, answer_sizes_, request_sums_;
  std::int64_t forgotten_ = 0;  // the requests up to this number are deleted
};

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_APPEND_H_
