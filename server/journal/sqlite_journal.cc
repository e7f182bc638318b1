#include "server/journal/sqlite_journal.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"

namespace dynmesh::server {
namespace {

using sqlite::Connection;
using sqlite::Statement;

// Rows are small or far larger than a page; WITHOUT ROWID spares each a second tree.
constexpr char kTables[] = R"(
  CREATE TABLE meshes(
    key INTEGER PRIMARY KEY AUTOINCREMENT,
    id TEXT NOT NULL UNIQUE,
    description BLOB NOT NULL,
    snapshot INTEGER NOT NULL,  -- its revision
    head INTEGER NOT NULL);     -- the last entry's, or the snapshot's
  CREATE TABLE snapshots(
    mesh INTEGER NOT NULL, part INTEGER NOT NULL, data BLOB NOT NULL,
    PRIMARY KEY(mesh, part)) WITHOUT ROWID;
  CREATE TABLE entries(
    mesh INTEGER NOT NULL, revision INTEGER NOT NULL, data BLOB NOT NULL,
    PRIMARY KEY(mesh, revision)) WITHOUT ROWID;
  CREATE TABLE requests(
    mesh INTEGER NOT NULL, number INTEGER NOT NULL, id TEXT NOT NULL, answer BLOB NOT NULL,
    PRIMARY KEY(mesh, number)) WITHOUT ROWID;
  CREATE TABLE probes(number INTEGER PRIMARY KEY);
  INSERT INTO probes VALUES(0);
)";

absl::StatusOr<std::int64_t> IntegerOf(const Connection& connection, const char* sql) {
  Statement statement(connection, sql);
  const bool row = statement.Step();
  if (!statement.status().ok()) return statement.status();
  return row ? statement.Integer(0) : 0;
}

// Makes the tables, or finds that they are there.
absl::Status Prepare(Connection& connection, const std::string& path) {
  if (absl::Status s = connection.Run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;"
                                      "PRAGMA journal_size_limit=67108864");
      !s.ok()) {
    return s;
  }
  const auto version = IntegerOf(connection, "PRAGMA user_version");
  if (!version.ok()) return version.status();
  if (*version > SqliteJournal::kSchema) {
    return absl::FailedPreconditionError(
        absl::StrCat(path, " has schema ", *version, ", this dynmeshd knows ",
                     SqliteJournal::kSchema, ": take the newer version that wrote it"));
  }
  if (*version == SqliteJournal::kSchema) return absl::OkStatus();
  const std::string sql = absl::StrCat("BEGIN IMMEDIATE;", kTables,
                                       "PRAGMA user_version=", SqliteJournal::kSchema, ";COMMIT");
  return connection.Run(sql.c_str());
}

absl::Status NoSuchMesh() { return absl::NotFoundError("the journal has no such mesh"); }

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteJournal>> SqliteJournal::Open(const std::string& folder,
                                                                   const Options& options) {
  absl::StatusOr<FolderLock> lock = FolderLock::Take(folder);
  if (!lock.ok()) return lock.status();
  const std::string path = absl::StrCat(folder, "/journal.sqlite");
  absl::StatusOr<Connection> connection = Connection::Open(path, options.vfs);
  if (!connection.ok()) return connection.status();
  if (absl::Status s = Prepare(*connection, path); !s.ok()) {
    return absl::Status(s.code(), absl::StrCat(path, ": ", s.message()));
  }
  return std::unique_ptr<SqliteJournal>(
      new SqliteJournal(path, options, *std::move(lock), *std::move(connection)));
}

SqliteJournal::SqliteJournal(std::string path, const Options& options, FolderLock lock,
                             Connection connection)
    : path_(std::move(path)),
      options_(options),
      lock_(std::move(lock)),
      writer_(std::move(connection)),
      thread_([this] { Run(); }) {}

SqliteJournal::~SqliteJournal() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

// ------------------------------------------------------------------ the writer

absl::Status SqliteJournal::Write(const Change& change) {
  Waiting mine{&change, {}};
  std::unique_lock lock(mutex_);
  waiting_.push_back(&mine);
  wake_.notify_one();
  ended_.wait(lock, [&] { return mine.done; });
  return mine.result;
}

void SqliteJournal::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const std::vector<Waiting*> group(waiting_.begin(), waiting_.end());
    waiting_.clear();
    lock.unlock();
    absl::Status status = failed_ ? Probe() : absl::OkStatus();
    if (status.ok()) status = Commit(group);
    if (!status.ok() && !failed_) {
      Log(LogLevel::kError, "journal_failed", {{"journal", path_}, {"error", status.message()}});
    } else if (status.ok() && failed_) {
      Log(LogLevel::kInfo, "journal_works_again", {{"journal", path_}});
    }
    failed_ = !status.ok();
    ++(failed_ ? failures_ : syncs_);
    lock.lock();
    for (Waiting* waiting : group) {
      if (!status.ok()) waiting->result = status;
      waiting->done = true;
    }
    ended_.notify_all();
  }
}

// Not OK: nothing of the group was done.
absl::Status SqliteJournal::Commit(const std::vector<Waiting*>& group) {
  absl::Status status = writer_.Run("BEGIN IMMEDIATE");
  for (std::size_t i = 0; status.ok() && i < group.size(); ++i) {
    group[i]->result = (*group[i]->change)();
    if (absl::IsUnavailable(group[i]->result) || absl::IsDataLoss(group[i]->result)) {
      status = group[i]->result;
    }
  }
  if (status.ok()) status = writer_.Run("COMMIT");
  if (!status.ok() && !writer_.autocommit()) {
    // It cannot be left open: the next transaction would go on with it.
    if (absl::Status s = writer_.Run("ROLLBACK"); !s.ok()) {
      Log(LogLevel::kError, "rollback_failed", {{"journal", path_}, {"error", s.message()}});
    }
  }
  return status;
}

absl::Status SqliteJournal::Probe() {
  const Change probe = [this] { return writer_.Run("UPDATE probes SET number = number + 1"); };
  Waiting waiting{&probe, {}};
  return Commit({&waiting});
}

// ------------------------------------------------------------------ changes

absl::StatusOr<Journal::Key> SqliteJournal::Create(const std::string& id,
                                                   const std::string& description) {
  Key key = 0;
  const absl::Status status = Write([&]() -> absl::Status {
    Statement find(writer_, "SELECT 1 FROM meshes WHERE id = ?");
    if (find.BindText(id).Step()) {
      return absl::AlreadyExistsError(absl::StrCat("the journal has a mesh ", id, " already"));
    }
    if (!find.status().ok()) return find.status();
    Statement insert(writer_,
                     "INSERT INTO meshes(id, description, snapshot, head) VALUES(?, ?, 0, 0)");
    if (absl::Status s = insert.BindText(id).BindBytes(description).Finish(); !s.ok()) return s;
    key = sqlite3_last_insert_rowid(writer_.get());
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  return key;
}

absl::Status SqliteJournal::Run(const char* sql, Key mesh) {
  return Statement(writer_, sql).Bind(mesh).Finish();
}

absl::Status SqliteJournal::Delete(Key mesh) {
  return Write([&]() -> absl::Status {
    if (auto last = LastOf(mesh); !last.ok()) return last.status();
    for (const char* sql :
         {"DELETE FROM meshes WHERE key = ?", "DELETE FROM snapshots WHERE mesh = ?",
          "DELETE FROM entries WHERE mesh = ?", "DELETE FROM requests WHERE mesh = ?"}) {
      if (absl::Status s = Run(sql, mesh); !s.ok()) return s;
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<std::int64_t> SqliteJournal::LastOf(Key mesh) {
  Statement find(writer_, "SELECT head FROM meshes WHERE key = ?");
  if (find.Bind(mesh).Step()) return find.Integer(0);
  return find.status().ok() ? NoSuchMesh() : find.status();
}

absl::Status SqliteJournal::Append(Key mesh, const Entry& entry) {
  const auto revision = static_cast<std::int64_t>(entry.revision);
  Statement insert(writer_, "INSERT INTO entries VALUES(?, ?, ?)");
  insert.Bind(mesh).Bind(revision).BindBytes(entry.data);
  if (absl::Status s = insert.Finish(); !s.ok()) return s;
  Statement head(writer_, "UPDATE meshes SET head = ? WHERE key = ?");
  return head.Bind(revision).Bind(mesh).Finish();
}

absl::Status SqliteJournal::Append(Key mesh, const Request& request) {
  Statement last(writer_, "SELECT ifnull(max(number), 0) FROM requests WHERE mesh = ?");
  last.Bind(mesh).Step();
  if (!last.status().ok()) return last.status();
  const std::int64_t number = last.Integer(0) + 1;
  Statement insert(writer_, "INSERT INTO requests VALUES(?, ?, ?, ?)");
  insert.Bind(mesh).Bind(number).BindText(request.id).BindBytes(request.answer);
  if (absl::Status s = insert.Finish(); !s.ok()) return s;
  Statement trim(writer_, "DELETE FROM requests WHERE mesh = ? AND number <= ?");
  return trim.Bind(mesh)
      .Bind(number - static_cast<std::int64_t>(options_.remembered_requests))
      .Finish();
}

absl::Status SqliteJournal::Append(Key mesh, const std::optional<Entry>& entry,
                                   const std::optional<Request>& request) {
  return Write([&]() -> absl::Status {
    const absl::StatusOr<std::int64_t> last = LastOf(mesh);
    if (!last.ok()) return last.status();
    if (entry.has_value()) {
      if (static_cast<std::int64_t>(entry->revision) != *last + 1) {
        return absl::FailedPreconditionError(
            absl::StrCat("revision ", entry->revision, " does not follow the journal's ", *last));
      }
      if (absl::Status s = Append(mesh, *entry); !s.ok()) return s;
    }
    return request.has_value() ? Append(mesh, *request) : absl::OkStatus();
  });
}

absl::Status SqliteJournal::Compact(Key mesh, std::uint64_t revision,
                                    const std::vector<std::string>& parts) {
  return Write([&]() -> absl::Status {
    const absl::StatusOr<std::int64_t> last = LastOf(mesh);
    if (!last.ok()) return last.status();
    if (static_cast<std::int64_t>(revision) != *last) {
      return absl::FailedPreconditionError(
          absl::StrCat("revision ", revision, " is not the journal's last, which is ", *last));
    }
    for (const char* sql :
         {"DELETE FROM snapshots WHERE mesh = ?", "DELETE FROM entries WHERE mesh = ?"}) {
      if (absl::Status s = Run(sql, mesh); !s.ok()) return s;
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      Statement insert(writer_, "INSERT INTO snapshots VALUES(?, ?, ?)");
      insert.Bind(mesh).Bind(static_cast<std::int64_t>(i)).BindBytes(parts[i]);
      if (absl::Status s = insert.Finish(); !s.ok()) return s;
    }
    return Statement(writer_, "UPDATE meshes SET snapshot = ? WHERE key = ?")
        .Bind(*last)
        .Bind(mesh)
        .Finish();
  });
}

// ------------------------------------------------------------------ reading

absl::StatusOr<std::vector<Journal::Mesh>> SqliteJournal::List() {
  absl::StatusOr<Connection> reader = Connection::Open(path_, options_.vfs);
  if (!reader.ok()) return reader.status();
  std::vector<Mesh> meshes;
  Statement rows(*reader,
                 "SELECT key, id, description, head - snapshot + (snapshot > 0) "
                 "FROM meshes ORDER BY id");
  while (rows.Step()) {
    meshes.push_back({rows.Integer(0), rows.Bytes(1), rows.Bytes(2),
                      static_cast<std::uint64_t>(rows.Integer(3))});
  }
  if (!rows.status().ok()) return rows.status();
  return meshes;
}

absl::Status SqliteJournal::Read(Key mesh, const Visitor& visitor) {
  absl::StatusOr<Connection> reader = Connection::Open(path_, options_.vfs);
  if (!reader.ok()) return reader.status();
  // One transaction, so that all is of one moment.
  if (absl::Status s = reader->Run("BEGIN"); !s.ok()) return s;
  Statement found(*reader, "SELECT snapshot, head FROM meshes WHERE key = ?");
  if (!found.Bind(mesh).Step()) return found.status().ok() ? NoSuchMesh() : found.status();
  const auto snapshot = static_cast<std::uint64_t>(found.Integer(0));
  const auto head = static_cast<std::uint64_t>(found.Integer(1));

  Statement requests(*reader, "SELECT id, answer FROM requests WHERE mesh = ? ORDER BY number");
  requests.Bind(mesh);
  while (requests.Step()) {
    const Request request{requests.Bytes(0), requests.Bytes(1)};
    if (absl::Status s = visitor.request(request); !s.ok()) return s;
  }
  if (!requests.status().ok()) return requests.status();

  Statement parts(*reader, "SELECT data FROM snapshots WHERE mesh = ? ORDER BY part");
  parts.Bind(mesh);
  bool any = false;
  while (parts.Step()) {
    any = true;
    if (absl::Status s = visitor.snapshot(snapshot, parts.Bytes(0)); !s.ok()) return s;
  }
  if (!parts.status().ok()) return parts.status();
  if (snapshot > 0 && !any) return absl::DataLossError("its snapshot is missing");

  Statement entries(*reader, "SELECT revision, data FROM entries WHERE mesh = ? ORDER BY revision");
  entries.Bind(mesh);
  std::uint64_t last = snapshot;
  while (entries.Step()) {
    const Entry entry{static_cast<std::uint64_t>(entries.Integer(0)), entries.Bytes(1)};
    if (entry.revision != ++last) break;
    if (absl::Status s = visitor.entry(entry); !s.ok()) return s;
  }
  if (!entries.status().ok()) return entries.status();
  if (last == head) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat("of its revisions up to ", head, " some are missing"));
}

}  // namespace dynmesh::server
