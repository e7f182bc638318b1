// A wrapper of the part of SQLite's C interface that the journal needs: RAII connections and
// statements, results as statuses. Thread-compatible.
#ifndef DYNMESH_SERVER_JOURNAL_SQLITE_H_
#define DYNMESH_SERVER_JOURNAL_SQLITE_H_

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server::sqlite {

// UNAVAILABLE, or DATA_LOSS if `code` means a damaged file. OK for SQLITE_OK.
absl::Status StatusOf(int code, absl::string_view doing, absl::string_view message);

class Connection {
 public:
  // Whether a missing file is made.
  enum class Missing { kMake, kRefuse };
  // `vfs` null: the default one. Waits up to some seconds for other connections.
  static absl::StatusOr<Connection> Open(const std::string& path, const char* vfs,
                                         Missing missing = Missing::kMake);

  // Whether SQLite moves its log into the database and deletes it when the last connection is
  // closed. The default is true.
  void MoveLogAtEnd(bool yes);
  // Statements without a result, separated by semicolons.
  absl::Status Run(const char* sql);
  // False in a transaction; a failed statement may have ended it.
  bool autocommit() const { return sqlite3_get_autocommit(db_.get()) != 0; }
  absl::Status StatusOf(int code, absl::string_view doing) const;
  sqlite3* get() const { return db_.get(); }

 private:
  friend class Statement;
  struct Close {
    void operator()(sqlite3* db) const { sqlite3_close_v2(db); }
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  using Prepared = std::unique_ptr<sqlite3_stmt, Close>;

  // A cached statement, or null.
  Prepared TakePrepared(const char* sql);

  std::unique_ptr<sqlite3, Close> db_;
  std::vector<Prepared> put_by_;  // a cache: parsing takes longer than running
};

// A prepared statement. Errors are kept: bind, step and read, then check status(). Bound values
// must outlive the stepping. The connection caches it for the next statement with the same text.
class Statement {
 public:
  Statement(Connection& connection, const char* sql);
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;
  ~Statement();

  // Binds the next parameter.
  Statement& Bind(std::int64_t value);
  Statement& BindText(absl::string_view text);
  Statement& BindBytes(absl::string_view bytes);

  // True if there is a row.
  bool Step();
  std::int64_t Integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  std::string Bytes(int column) const;
  bool IsNull(int column) const {
    return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
  }
  const absl::Status& status() const { return status_; }

  // Steps to the end.
  absl::Status Finish();

 private:
  void Take(int code);

  Connection& connection_;
  const char* const sql_;
  Connection::Prepared statement_;
  int bound_ = 0;
  absl::Status status_;
};

}  // namespace dynmesh::server::sqlite

#endif  // DYNMESH_SERVER_JOURNAL_SQLITE_H_
