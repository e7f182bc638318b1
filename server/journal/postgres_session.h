// A wrapper of the part of libpqxx that the journal needs: a connection, statements and their
// results, exceptions as statuses. Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_SESSION_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_SESSION_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <pqxx/pqxx>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace dynmesh::server::postgres {

// The outcome of a statement.
struct Answer {
  absl::Status status;
  bool unknown = false;  // with an error: as of postgres_errors.h
  pqxx::result rows;

  bool empty() const { return rows.empty(); }
  std::size_t size() const { return static_cast<std::size_t>(rows.size()); }
  // Of the row and the column, from 0 on, which exist.
  std::int64_t Integer(std::size_t row, int column) const;
  std::string Bytes(std::size_t row, int column) const;
  bool IsNull(std::size_t row, int column) const;
};

// A parameter of the type bytea; the bytes are copied.
struct Bytes {
  absl::string_view bytes;
};

class Session {
 public:
  // Connects, with settings under which a commit is durable when it is answered: no time limits
  // of statements, and synchronous_commit at least `on`. UNAVAILABLE, with what to do if that is
  // known; nothing is unknown then. `conninfo` as of Target. `between_statements` > 0: a
  // transaction that waits longer for its next statement is undone, and the connection is closed.
  // So the locks of a server that stops in one, or is cut off, do not stay.
  static absl::StatusOr<std::unique_ptr<Session>> Connect(
      const std::string& conninfo, absl::Duration between_statements = absl::ZeroDuration());
  ~Session();

  // Runs one statement, prepared at its first use; `sql` is a constant. Parameters: integers, text,
  // Bytes, vectors of integers. Outside of a transaction it is one by itself. A warning of the
  // server, as "canceling wait for synchronous replication", makes the outcome unknown.
  template <typename... Parameters>
  Answer Run(const char* sql, const Parameters&... parameters) {
    return Guarded([&](pqxx::nontransaction& work) {
      return work.exec_prepared(Prepared(sql), Encoded(parameters)...);
    });
  }
  // Runs one or more statements without parameters; the rows are those of the last.
  Answer Execute(const std::string& sql);

  // False after an error: the state of the connection is not known any more.
  bool usable() const { return usable_; }
  // True if the server closed an idle connection, or said something on it: nothing is to be sent
  // there, as its end would be unknown. A system call.
  bool IsStale() const;
  // An error of a call came from this session's transaction, which is to be ended with it.
  void Spoil() { usable_ = false; }

 private:
  class Listener;

  Session();
  Answer Guarded(const std::function<pqxx::result(pqxx::nontransaction&)>& statement);
  const std::string& Prepared(const char* sql);

  static std::int64_t Encoded(std::int64_t number) { return number; }
  static const std::string& Encoded(const std::string& text) { return text; }
  static pqxx::binarystring Encoded(const Bytes& bytes) {
    return pqxx::binarystring(bytes.bytes.data(), bytes.bytes.size());
  }
  static std::string Encoded(const std::vector<std::int64_t>& numbers);

  std::unique_ptr<pqxx::connection> connection_;  // outlives its listener
  std::unique_ptr<Listener> listener_;
  std::map<const char*, std::string> prepared_;
  bool usable_ = true;
};

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_SESSION_H_
