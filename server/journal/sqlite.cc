#include "server/journal/sqlite.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/printable.h"

namespace dynmesh::server::sqlite {
namespace {

constexpr int kBusyMilliseconds = 10'000;

}  // namespace

absl::Status StatusOf(int code, absl::string_view doing, absl::string_view message) {
  const int primary = code & 0xff;
  if (primary == SQLITE_OK || primary == SQLITE_ROW || primary == SQLITE_DONE) {
    return absl::OkStatus();
  }
  // If a schema is unreadable, SQLite repeats it in the message.
  std::string what = absl::StrCat(doing, ": ", Printable(message), " (SQLite ", code, ")");
  if (primary == SQLITE_CORRUPT || primary == SQLITE_NOTADB) return absl::DataLossError(what);
  return absl::UnavailableError(what);
}

absl::StatusOr<Connection> Connection::Open(const std::string& path, const char* vfs,
                                            Missing missing) {
  Connection connection;
  sqlite3* db = nullptr;
  const int make = missing == Missing::kMake ? SQLITE_OPEN_CREATE : 0;
  const int code =
      sqlite3_open_v2(path.c_str(), &db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX | make, vfs);
  connection.db_.reset(db);
  if (code != SQLITE_OK) {
    return sqlite::StatusOf(code, absl::StrCat("opening ", path),
                            db != nullptr ? sqlite3_errmsg(db) : sqlite3_errstr(code));
  }
  sqlite3_extended_result_codes(db, 1);
  sqlite3_busy_timeout(db, kBusyMilliseconds);
  return connection;
}

absl::Status Connection::StatusOf(int code, absl::string_view doing) const {
  return sqlite::StatusOf(code, doing, sqlite3_errmsg(db_.get()));
}

void Connection::MoveLogAtEnd(bool yes) {
  sqlite3_db_config(db_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, yes ? 0 : 1, nullptr);
}

absl::Status Connection::Run(const char* sql) {
  return StatusOf(sqlite3_exec(db_.get(), sql, nullptr, nullptr, nullptr), sql);
}

Connection::Prepared Connection::TakePrepared(const char* sql) {
  const auto same = std::find_if(put_by_.begin(), put_by_.end(), [sql](const Prepared& p) {
    return std::strcmp(sqlite3_sql(p.get()), sql) == 0;
  });
  if (same == put_by_.end()) return nullptr;
  Prepared taken = std::move(*same);
  *same = std::move(put_by_.back());
  put_by_.pop_back();
  return taken;
}

Statement::Statement(Connection& connection, const char* sql)
    : connection_(connection), sql_(sql), statement_(connection.TakePrepared(sql)) {
  if (statement_ != nullptr) return;
  sqlite3_stmt* statement = nullptr;
  Take(sqlite3_prepare_v3(connection.get(), sql, -1, SQLITE_PREPARE_PERSISTENT, &statement,
                          nullptr));
  statement_.reset(statement);
}

Statement::~Statement() {
  if (!status_.ok() || statement_ == nullptr) return;
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
  connection_.put_by_.push_back(std::move(statement_));
}

void Statement::Take(int code) {
  if (status_.ok()) status_ = connection_.StatusOf(code, sql_);
}

Statement& Statement::Bind(std::int64_t value) {
  if (status_.ok()) Take(sqlite3_bind_int64(statement_.get(), ++bound_, value));
  return *this;
}

Statement& Statement::BindText(absl::string_view text) {
  if (status_.ok()) {
    Take(sqlite3_bind_text64(statement_.get(), ++bound_, text.data(), text.size(), SQLITE_STATIC,
                             SQLITE_UTF8));
  }
  return *this;
}

Statement& Statement::BindBytes(absl::string_view bytes) {
  if (status_.ok()) {
    // A null pointer would be NULL, not an empty blob.
    Take(sqlite3_bind_blob64(statement_.get(), ++bound_, bytes.empty() ? "" : bytes.data(),
                             bytes.size(), SQLITE_STATIC));
  }
  return *this;
}

bool Statement::Step() {
  if (!status_.ok()) return false;
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  Take(code);
  return false;
}

std::string Statement::Bytes(int column) const {
  const void* data = sqlite3_column_blob(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return data == nullptr
             ? std::string()
             : std::string(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

absl::Status Statement::Finish() {
  while (Step()) {
  }
  return status_;
}

}  // namespace dynmesh::server::sqlite
