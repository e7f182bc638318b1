#include "server/journal/sqlite_journal.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/journal/journal_errors.h"
#include "server/journal/row_sum.h"
#include "server/journal/sqlite_generations.h"
#include "server/journal/wal_walk.h"

namespace dynmesh::server {
namespace {

using sqlite::Connection;
using sqlite::Statement;

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteJournal>> SqliteJournal::Open(const std::string& folder,
                                                                   const Options& options) {
  absl::StatusOr<FolderLock> lock = FolderLock::Take(folder);
  if (!lock.ok()) return lock.status();
  const std::string path = absl::StrCat(folder, "/journal.sqlite");
  absl::StatusOr<OpenedJournal> opened = OpenJournalFiles(folder, options.vfs, options.accept_loss);
  if (!opened.ok()) return opened.status();
  absl::StatusOr<Connection> mover = Connection::Open(path, options.vfs);
  if (!mover.ok()) return mover.status();
  std::unique_ptr<SqliteJournal> journal(new SqliteJournal(folder, path, options, *std::move(lock),
                                                           *std::move(opened), *std::move(mover)));
  // With losses, a leftover may be all that is left of a mesh.
  if (!journal->has_losses_) journal->SweepAll();
  return journal;
}

SqliteJournal::SqliteJournal(const std::string& folder, std::string path, const Options& options,
                             FolderLock lock, OpenedJournal opened, Connection mover)
    : path_(std::move(path)),
      options_(options),
      lock_(std::move(lock)),
      sealed_(opened.sealed),
      has_losses_(!opened.losses.empty() || !opened.sealed.ok()),
      writer_(std::move(opened.connection)),
      heads_(std::move(opened.heads)),
      presence_(path_, {path_, path_ + "-wal", absl::StrCat(folder, "/", HeadsFile::kFileName)}),
      checkpointer_(std::move(mover)) {
  for (Loss& loss : opened.losses) losses_.emplace(loss.key(), std::move(loss));
  // Replaces SQLite's own hook, which moves the log within a commit.
  sqlite3_wal_hook(
      writer_.get(),
      [](void* journal, sqlite3*, const char*, int pages) {
        static_cast<SqliteJournal*>(journal)->log_pages_ = pages;
        return SQLITE_OK;
      },
      this);
}

// If the folder is gone, SQLite must not delete a log at its path: it may be another journal's.
SqliteJournal::~SqliteJournal() {
  if (presence_.Look().ok()) return;
  writer_.MoveLogAtEnd(false);
  checkpointer_.KeepLogAtEnd();
}

Journal::Counts SqliteJournal::counts() const {
  const bool gone = presence_.gone();
  return {syncs_.load(), failures_.load(), failed_ || gone, 0, 0, gone, under_way_.Oldest()};
}

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
  if (!sealed_.ok()) return sealed_;
  const WritesUnderWay::Write write(under_way_);
  Waiting mine{&change, {}};
  const MutexLock lock(mutex_);
  if (absl::Status ended = under_way_.ended(); !ended.ok()) return ended;
  waiting_.push_back(&mine);
  ended_.Wait(mutex_,
              [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return mine.done || !writing_; });
  if (!mine.done) WriteAll();
  return mine.result;
}

void SqliteJournal::EndWrites(const absl::Status& why) {
  const MutexLock lock(mutex_);
  under_way_.End(why);
  for (Waiting* waiting : std::exchange(waiting_, {})) {
    waiting->result = why;
    waiting->done = true;
  }
  ended_.NotifyAll();
}

// On the caller's own thread, which saves two thread switches.
void SqliteJournal::WriteAll() {
  writing_ = true;
  const std::vector<Waiting*> group = std::exchange(waiting_, {});
  mutex_.Unlock();
  const bool failed_before = failed_;
  bool refused = false;
  absl::Status status = failed_before ? Probe(&refused) : absl::OkStatus();
  if (status.ok()) status = Commit(group, &refused);
  const bool failed = refused ? failed_before : !status.ok();
  if (failed && !failed_before) {
    Log(LogLevel::kError, "journal_failed", {{"journal", path_}, {"error", status.message()}});
  } else if (failed_before && !failed) {
    Log(LogLevel::kInfo, "journal_works_again", {{"journal", path_}});
  }
  failed_ = failed;
  ++(status.ok() ? syncs_ : failures_);
  if (status.ok()) {
    heads_->Publish(LogPosition());
    checkpointer_.Committed(log_pages_, writer_);
  }
  mutex_.Lock();
  for (Waiting* waiting : group) {
    if (!status.ok()) waiting->result = status;
    waiting->done = true;
  }
  writing_ = false;
  ended_.NotifyAll();
}

// Not OK: the group had no effect.
absl::Status SqliteJournal::Commit(const std::vector<Waiting*>& group, bool* refused) {
  heads_->Drop();
  absl::Status status = Statement(writer_, "BEGIN IMMEDIATE").Finish();
  for (std::size_t i = 0; status.ok() && i < group.size(); ++i) {
    group[i]->result = (*group[i]->change)();
    if (absl::IsUnavailable(group[i]->result) || absl::IsDataLoss(group[i]->result)) {
      status = group[i]->result;
    }
  }
  if (status.ok()) {
    status = presence_.Look();
    *refused = !status.ok();
  }
  if (status.ok()) status = Statement(writer_, "COMMIT").Finish();
  if (!status.ok() && !writer_.autocommit()) {
    // It must not stay open: the next transaction would continue it.
    if (absl::Status s = writer_.Run("ROLLBACK"); !s.ok()) {
      Log(LogLevel::kError, "rollback_failed", {{"journal", path_}, {"error", s.message()}});
    }
  }
  return status;
}

HeadsFile::Position SqliteJournal::LogPosition() {
  // A log that begins anew has another salt.
  if (log_pages_ <= position_pages_ || log_salt_ == 0) log_salt_ = WalSalt(path_ + "-wal");
  position_pages_ = log_pages_;
  return {log_salt_, static_cast<std::uint64_t>(log_pages_)};
}

absl::Status SqliteJournal::Probe(bool* refused) {
  const Change probe = [this] { return writer_.Run("UPDATE probes SET number = number + 1"); };
  Waiting waiting{&probe, {}};
  return Commit({&waiting}, refused);
}

// ------------------------------------------------------------------ changes

absl::StatusOr<Journal::Key> SqliteJournal::Create(const std::string& id,
                                                   const std::string& description) {
  Key key = 0;
  const absl::Status status = Write([&]() -> absl::Status {
    if (absl::Status s = CheckNew(id); !s.ok()) return s;
    const absl::StatusOr<Key> made = InsertMesh(id, description);
    if (!made.ok()) return made.status();
    key = *made;
    heads_->Stage({key, id, 0, 0, 0, HeadsFile::State::kThere});
    return Run("INSERT INTO generations VALUES(?, 0, 0, 0)", key);
  });
  if (!status.ok()) return status;
  return key;
}

absl::Status SqliteJournal::CheckNew(const std::string& id) {
  Statement find(writer_, "SELECT 1 FROM meshes WHERE id = ?");
  if (find.BindText(id).Step()) return MeshExists(id);
  return find.status();
}

absl::StatusOr<Journal::Key> SqliteJournal::InsertMesh(const std::string& id,
                                                       const std::string& description) {
  Statement insert(writer_,
                   "INSERT INTO meshes(key, id, description, snapshot, head, checksum) "
                   "VALUES(max(?, ifnull((SELECT seq FROM sqlite_sequence WHERE name = "
                   "'meshes'), 0)) + 1, ?, ?, 0, 0, ?)");
  // Greater than any key given before the journal lost something.
  insert.Bind(heads_->greatest()).BindText(id).BindBytes(description);
  insert.Bind(RowSumOf(absl::string_view(id), absl::string_view(description)));
  if (absl::Status s = insert.Finish(); !s.ok()) return s;
  return sqlite3_last_insert_rowid(writer_.get());
}

absl::Status SqliteJournal::Run(const char* sql, Key mesh) {
  return Statement(writer_, sql).Bind(mesh).Finish();
}

absl::Status SqliteJournal::Delete(Key mesh) {
  if (!sealed_.ok()) return sealed_;
  const WritesUnderWay::Write write(under_way_);
  if (absl::Status ended = under_way_.ended(); !ended.ok()) return ended;
  if (absl::Status gone = presence_.Look(); !gone.ok()) return gone;
  if (TakeMissing(mesh)) {
    absl::Status status = heads_->Forget(mesh);
    return status.ok() ? heads_->Sync() : status;
  }
  // A deleted mesh that is still on record would count as lost.
  if (absl::Status s = heads_->BeginDelete(mesh); !s.ok()) return s;
  absl::Status status = Write([&]() -> absl::Status {
    if (auto last = LastOf(mesh); !last.ok()) return last.status();
    for (const char* sql :
         {"DELETE FROM meshes WHERE key = ?", "DELETE FROM generations WHERE mesh = ?",
          "DELETE FROM requests WHERE mesh = ?"}) {
      if (absl::Status s = Run(sql, mesh); !s.ok()) return s;
    }
    return absl::OkStatus();
  });
  if (status.ok()) heads_->EndDelete(mesh);
  return status;
}

bool SqliteJournal::TakeMissing(Key mesh) {
  const MutexLock lock(losses_mutex_);
  const auto it = losses_.find(mesh);
  if (it == losses_.end() || it->second.found.key != 0) return false;
  losses_.erase(it);
  return true;
}

absl::Status SqliteJournal::CheckWritable(Key mesh) {
  if (!has_losses_) return absl::OkStatus();
  const MutexLock lock(losses_mutex_);
  const auto it = losses_.find(mesh);
  return it == losses_.end() ? absl::OkStatus() : absl::DataLossError(it->second.Text());
}

absl::StatusOr<std::int64_t> SqliteJournal::LastOf(Key mesh) {
  Statement find(writer_, "SELECT head FROM meshes WHERE key = ?");
  if (find.Bind(mesh).Step()) return find.Integer(0);
  return find.status().ok() ? NoSuchMesh() : find.status();
}

absl::StatusOr<std::int64_t> SqliteJournal::InsertEntry(Key mesh, const Entry& entry) {
  const auto revision = static_cast<std::int64_t>(entry.revision);
  Statement insert(writer_, "INSERT INTO entries VALUES(?, ?, ?, ?)");
  const std::int64_t sum = RowSumOf(mesh, revision, absl::string_view(entry.data));
  insert.Bind(mesh).Bind(revision).BindBytes(entry.data).Bind(sum);
  if (absl::Status s = insert.Finish(); !s.ok()) return s;
  return sum;
}

absl::Status SqliteJournal::InsertRequest(Key mesh, std::int64_t number, const Request& request) {
  Statement insert(writer_, "INSERT INTO requests VALUES(?, ?, ?, ?, ?)");
  insert.Bind(mesh).Bind(number).BindText(request.id).BindBytes(request.answer);
  insert.Bind(
      RowSumOf(mesh, number, absl::string_view(request.id), absl::string_view(request.answer)));
  return insert.Finish();
}

absl::Status SqliteJournal::AppendEntries(Key mesh, const std::vector<Entry>& entries) {
  std::int64_t bytes = 0;
  for (const Entry& entry : entries) {
    const absl::StatusOr<std::int64_t> sum = InsertEntry(mesh, entry);
    if (!sum.ok()) return sum.status();
    heads_->StageEntry(mesh, entry.revision, *sum);
    bytes += static_cast<std::int64_t>(entry.data.size());
  }
  Statement head(writer_, "UPDATE meshes SET head = ?, tail_bytes = tail_bytes + ? WHERE key = ?");
  const auto last = static_cast<std::int64_t>(entries.back().revision);
  return head.Bind(last).Bind(bytes).Bind(mesh).Finish();
}

absl::Status SqliteJournal::AppendRequests(Key mesh, const std::vector<Request>& requests) {
  Statement newest(writer_, "SELECT ifnull(max(number), 0) FROM requests WHERE mesh = ?");
  newest.Bind(mesh).Step();
  if (!newest.status().ok()) return newest.status();
  const std::int64_t before = newest.Integer(0);
  std::int64_t number = before;
  for (const Request& request : requests) {
    if (absl::Status s = InsertRequest(mesh, ++number, request); !s.ok()) return s;
  }
  heads_->StageRequest(mesh, number);
  // The oldest rows are far from the newest: deleting them writes one more page. So they are
  // deleted by the hundred.
  const auto kept = static_cast<std::int64_t>(options_.remembered_requests);
  const std::int64_t at_once = 1 + kept / 100;
  if (number / at_once == before / at_once) return absl::OkStatus();
  Statement trim(writer_, "DELETE FROM requests WHERE mesh = ? AND number <= ?");
  return trim.Bind(mesh).Bind(number - kept).Finish();
}

absl::Status SqliteJournal::Append(Key mesh, const std::vector<Entry>& entries,
                                   const std::vector<Request>& requests) {
  if (absl::Status s = CheckWritable(mesh); !s.ok()) return s;
  return Write([&]() -> absl::Status {
    absl::StatusOr<std::int64_t> last = LastOf(mesh);
    if (!last.ok()) return last.status();
    for (const Entry& entry : entries) {
      if (static_cast<std::int64_t>(entry.revision) != *last + 1) {
        return OutOfSequence(entry.revision, *last);
      }
      ++*last;
    }
    absl::Status status;
    if (!entries.empty()) status = AppendEntries(mesh, entries);
    if (status.ok() && !requests.empty()) status = AppendRequests(mesh, requests);
    return status;
  });
}

// This process is the only one to write, and it writes a mesh's revisions in order. So another
// one writes if the journal has more.
absl::Status SqliteJournal::OutOfSequence(std::uint64_t revision, std::int64_t last) {
  if (static_cast<std::int64_t>(revision) > last) return NotTheNextRevision(revision, last);
  absl::Status another = WrittenByAnother(revision, last);
  if (!told_of_another_.exchange(true)) {
    Log(LogLevel::kError, "journal_shared", {{"journal", path_}, {"error", another.message()}});
  }
  return another;
}

// After a failure the rest is left for the next time.
bool SqliteJournal::Sweep(Key mesh) {
  bool more = false;
  const absl::Status status = Write([&]() -> absl::Status {
    const absl::StatusOr<bool> swept = SweepPart(writer_, mesh, options_.transaction_bytes);
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
