#include "server/journal/sqlite_journal.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/base/log.h"
#include "server/journal/row_sum.h"
#include "server/journal/sqlite_generations.h"
#include "server/journal/sqlite_schema.h"

namespace dynmesh::server {
namespace {

using sqlite::Connection;
using sqlite::Statement;

// Unless it is there: for nobody else to read. SQLite gives its other files the same rights.
absl::Status MakeJournalFile(const std::string& folder, const std::string& path) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0 && errno == EEXIST) return absl::OkStatus();
  if (file < 0) {
    return absl::UnavailableError(absl::StrCat("cannot make ", path, ": ", std::strerror(errno)));
  }
  close(file);
  // A backup that was put there under another name would be passed over.
  std::vector<std::string> others;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename();
    if (name != "lock" && name != "journal.sqlite") others.push_back(name);
  }
  if (!others.empty()) {
    Log(LogLevel::kWarning, "journal_made",
        {{"journal", path},
         {"others", absl::StrJoin(others, " ")},
         {"message",
          "a new journal, though the folder is not empty; a backup is read if it is "
          "called journal.sqlite"}});
  }
  return absl::OkStatus();
}

absl::Status NoSuchMesh() { return absl::NotFoundError("the journal has no such mesh"); }

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteJournal>> SqliteJournal::Open(const std::string& folder,
                                                                   const Options& options) {
  absl::StatusOr<FolderLock> lock = FolderLock::Take(folder);
  if (!lock.ok()) return lock.status();
  const std::string path = absl::StrCat(folder, "/journal.sqlite");
  if (absl::Status s = MakeJournalFile(folder, path); !s.ok()) return s;
  absl::StatusOr<Connection> connection = Connection::Open(path, options.vfs);
  if (!connection.ok()) return connection.status();
  if (absl::Status s = PrepareJournal(*connection, path); !s.ok()) {
    return absl::Status(s.code(), absl::StrCat(path, ": ", s.message()));
  }
  absl::StatusOr<Connection> mover = Connection::Open(path, options.vfs);
  if (!mover.ok()) return mover.status();
  std::unique_ptr<SqliteJournal> journal(new SqliteJournal(
      path, options, *std::move(lock), *std::move(connection), *std::move(mover)));
  journal->SweepAll();
  return journal;
}

SqliteJournal::SqliteJournal(std::string path, const Options& options, FolderLock lock,
                             Connection writer, Connection mover)
    : path_(std::move(path)),
      options_(options),
      lock_(std::move(lock)),
      writer_(std::move(writer)),
      checkpointer_(std::move(mover)) {
  // In the place of SQLite's own, which moves the log within a commit.
  sqlite3_wal_hook(
      writer_.get(),
      [](void* journal, sqlite3*, const char*, int pages) {
        static_cast<SqliteJournal*>(journal)->log_pages_ = pages;
        return SQLITE_OK;
      },
      this);
}

SqliteJournal::~SqliteJournal() = default;

std::uint64_t SqliteJournal::bytes() const {
  std::uint64_t sum = 0;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(absl::StrCat(path_, suffix), error);
    if (!error) sum += size;
  }
  return sum;
}

// ------------------------------------------------------------------ writing

absl::Status SqliteJournal::Write(const Change& change) {
  Waiting mine{&change, {}};
  std::unique_lock lock(mutex_);
  waiting_.push_back(&mine);
  ended_.wait(lock, [&] { return mine.done || !writing_; });
  if (!mine.done) WriteAll(lock);
  return mine.result;
}

// On the caller's own thread: another one would have to wait for a core, and then the caller again.
void SqliteJournal::WriteAll(std::unique_lock<std::mutex>& lock) {
  writing_ = true;
  const std::vector<Waiting*> group = std::exchange(waiting_, {});
  lock.unlock();
  const bool failed_before = failed_;
  absl::Status status = failed_before ? Probe() : absl::OkStatus();
  if (status.ok()) status = Commit(group);
  if (!status.ok() && !failed_before) {
    Log(LogLevel::kError, "journal_failed", {{"journal", path_}, {"error", status.message()}});
  } else if (status.ok() && failed_before) {
    Log(LogLevel::kInfo, "journal_works_again", {{"journal", path_}});
  }
  failed_ = !status.ok();
  ++(failed_ ? failures_ : syncs_);
  if (status.ok()) checkpointer_.Committed(log_pages_, writer_);
  lock.lock();
  for (Waiting* waiting : group) {
    if (!status.ok()) waiting->result = status;
    waiting->done = true;
  }
  writing_ = false;
  ended_.notify_all();
}

// Not OK: nothing of the group was done.
absl::Status SqliteJournal::Commit(const std::vector<Waiting*>& group) {
  absl::Status status = Statement(writer_, "BEGIN IMMEDIATE").Finish();
  for (std::size_t i = 0; status.ok() && i < group.size(); ++i) {
    group[i]->result = (*group[i]->change)();
    if (absl::IsUnavailable(group[i]->result) || absl::IsDataLoss(group[i]->result)) {
      status = group[i]->result;
    }
  }
  if (status.ok()) status = Statement(writer_, "COMMIT").Finish();
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
                     "INSERT INTO meshes(id, description, snapshot, head, checksum) "
                     "VALUES(?, ?, 0, 0, ?)");
    insert.BindText(id).BindBytes(description);
    insert.Bind(RowSumOf(absl::string_view(id), absl::string_view(description)));
    if (absl::Status s = insert.Finish(); !s.ok()) return s;
    key = sqlite3_last_insert_rowid(writer_.get());
    return Run("INSERT INTO generations VALUES(?, 0, 0, 0)", key);
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
         {"DELETE FROM meshes WHERE key = ?", "DELETE FROM generations WHERE mesh = ?",
          "DELETE FROM requests WHERE mesh = ?"}) {
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
  Statement insert(writer_, "INSERT INTO entries VALUES(?, ?, ?, ?)");
  insert.Bind(mesh).Bind(revision).BindBytes(entry.data);
  insert.Bind(RowSumOf(mesh, revision, absl::string_view(entry.data)));
  if (absl::Status s = insert.Finish(); !s.ok()) return s;
  Statement head(writer_, "UPDATE meshes SET head = ?, tail_bytes = tail_bytes + ? WHERE key = ?");
  return head.Bind(revision).Bind(static_cast<std::int64_t>(entry.data.size())).Bind(mesh).Finish();
}

absl::Status SqliteJournal::Append(Key mesh, const Request& request) {
  Statement last(writer_, "SELECT ifnull(max(number), 0) FROM requests WHERE mesh = ?");
  last.Bind(mesh).Step();
  if (!last.status().ok()) return last.status();
  const std::int64_t number = last.Integer(0) + 1;
  Statement insert(writer_, "INSERT INTO requests VALUES(?, ?, ?, ?, ?)");
  insert.Bind(mesh).Bind(number).BindText(request.id).BindBytes(request.answer);
  insert.Bind(
      RowSumOf(mesh, number, absl::string_view(request.id), absl::string_view(request.answer)));
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

absl::Status SqliteJournal::CheckLast(Key mesh, std::uint64_t revision) {
  const absl::StatusOr<std::int64_t> last = LastOf(mesh);
  if (!last.ok()) return last.status();
  if (static_cast<std::int64_t>(revision) == *last) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("revision ", revision, " is not the journal's last, which is ", *last));
}

absl::Status SqliteJournal::Compact(Key mesh, std::uint64_t revision,
                                    const std::vector<std::string>& parts) {
  const auto at = static_cast<std::int64_t>(revision);
  bool there = false;
  absl::Status status = Write([&]() -> absl::Status {
    if (absl::Status s = CheckLast(mesh, revision); !s.ok()) return s;
    Statement same(writer_, "SELECT 1 FROM generations WHERE mesh = ? AND revision = ?");
    there = same.Bind(mesh).Bind(at).Step();
    return same.status();
  });
  if (!status.ok() || there) return status;
  SweepWhole(mesh);  // of a snapshot that was not finished
  for (std::size_t part = 0; status.ok() && part < parts.size();) {
    status = Write([&]() -> absl::Status {
      if (absl::Status s = CheckLast(mesh, revision); !s.ok()) return s;
      const auto next = WriteParts(writer_, mesh, at, parts, part, options_.piece_bytes);
      if (next.ok()) part = *next;
      return next.status();
    });
  }
  if (status.ok()) {
    status = Write([&]() -> absl::Status {
      if (absl::Status s = CheckLast(mesh, revision); !s.ok()) return s;
      return SwitchOver(writer_, mesh, at, parts, options_.history_bytes);
    });
  }
  SweepWhole(mesh);
  return status;
}

// What cannot be taken away is left for the next time.
bool SqliteJournal::Sweep(Key mesh) {
  bool more = false;
  const absl::Status status = Write([&]() -> absl::Status {
    const absl::StatusOr<bool> swept = SweepPiece(writer_, mesh, options_.piece_bytes);
    more = swept.ok() && *swept;
    return swept.status();
  });
  if (status.ok()) return more;
  Log(LogLevel::kWarning, "sweep_failed", {{"journal", path_}, {"error", status.message()}});
  return false;
}

void SqliteJournal::SweepWhole(Key mesh) {
  while (Sweep(mesh)) {
  }
}

void SqliteJournal::SweepAll() {
  std::vector<Key> meshes;
  const absl::Status status = Write([&]() -> absl::Status {
    auto found = MeshesWithRows(writer_);
    if (found.ok()) meshes = *std::move(found);
    return found.status();
  });
  if (!status.ok()) {
    Log(LogLevel::kWarning, "sweep_failed", {{"journal", path_}, {"error", status.message()}});
  }
  for (const Key mesh : meshes) SweepWhole(mesh);
}

}  // namespace dynmesh::server
