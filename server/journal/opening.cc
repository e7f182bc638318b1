#include "server/journal/opening.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/base/log.h"
#include "server/base/printable.h"
#include "server/journal/found_meshes.h"
#include "server/journal/journal_folder.h"
#include "server/journal/row_sum.h"
#include "server/journal/sqlite_schema.h"
#include "server/journal/wal_walk.h"

namespace dynmesh::server {
namespace {

namespace fs = std::filesystem;
using sqlite::Connection;
using sqlite::Statement;
using RecordedHead = HeadsFile::Head;
using State = HeadsFile::State;
using Taking = HeadsFile::Taking;

class Opener {
 public:
  Opener(const std::string& folder, const char* vfs, const std::vector<std::string>& accepted)
      : folder_(folder),
        path_(absl::StrCat(folder, "/journal.sqlite")),
        log_path_(path_ + "-wal"),
        vfs_(vfs),
        accepted_(accepted) {}

  absl::StatusOr<OpenedJournal> Open() {
    if (absl::Status s = Steps(); !s.ok()) {
      return absl::Status(s.code(), absl::StrCat(path_, ": ", s.message()));
    }
    return std::move(out_);
  }

 private:
  absl::Status Steps();
  absl::Status Look();
  absl::Status LookIntoDatabase();
  absl::Status TakeRecord();
  absl::Status MakeRecord(const std::string& id, State state);
  absl::Status CheckSameJournal();
  absl::Status CheckStructure();
  absl::Status Compare();
  absl::Status BringUpToDate(bool doubt);
  absl::Status Accept();
  absl::Status SetLogAside();
  absl::Status Prepare();
  bool LogSaysMore() const;
  void TellWhatWasMade() const;
  void TellLosses() const;
  bool IsAccepted(absl::string_view what) const {
    return std::find(accepted_.begin(), accepted_.end(), what) != accepted_.end();
  }

  const std::string folder_, path_, log_path_;
  const char* const vfs_;
  const std::vector<std::string>& accepted_;

  DatabaseFormat format_ = DatabaseFormat::kNone;
  WalWalk walk_;
  std::int64_t version_ = 0;  // the schema's number
  bool is_new_ = false;       // there are no tables yet
  std::string id_;            // of the journal; empty: none yet
  std::vector<FoundMesh> found_;
  OpenedJournal out_;
};

// The losses are recorded, durably, before any write that would hide them.
absl::Status Opener::Steps() {
  if (absl::Status s = Look(); !s.ok()) return s;
  if (absl::Status s = TakeRecord(); !s.ok()) return s;
  if (walk_.damaged()) {
    if (absl::Status s = CheckStructure(); !s.ok()) return s;
  }
  if (is_new_) {
    if (!out_.sealed.ok()) return out_.sealed;
    if (absl::Status s = SetLogAside(); !s.ok()) return s;
    if (absl::Status s = Prepare(); !s.ok()) return s;
    TellWhatWasMade();
  }
  if (absl::Status s = Compare(); !s.ok()) return s;
  if (!out_.losses.empty()) {
    if (absl::Status s = CheckStructure(); !s.ok()) return s;
  }
  if (out_.sealed.ok()) {
    if (absl::Status s = Accept(); !s.ok()) return s;
  }
  TellLosses();
  if (is_new_) return absl::OkStatus();
  if (absl::Status s = SetLogAside(); !s.ok()) return s;
  return out_.sealed.ok() ? Prepare() : absl::OkStatus();
}

// ------------------------------------------------------------------ existing files

absl::Status Opener::Look() {
  const absl::StatusOr<WalWalk> walk = WalkWal(log_path_);
  if (!walk.ok()) return walk.status();
  walk_ = *walk;
  format_ = DatabaseFormatOf(path_);
  if (format_ == DatabaseFormat::kWhole && walk_.salt != 0) {
    return absl::FailedPreconditionError(absl::StrCat(
        "this is a backup, and a log that is not its own stands beside it: put the backup into an "
        "empty folder, or move ",
        log_path_, " away"));
  }
  if (FileSizeOf(path_) == 0 && FileSizeOf(log_path_) > 0) {
    // SQLite would take it for a leftover and delete it.
    const std::string kept = absl::StrCat(folder_, "/journal.lost.wal");
    std::error_code error;
    fs::rename(log_path_, kept, error);
    if (error) return absl::UnavailableError(absl::StrCat("cannot rename ", log_path_));
    Log(LogLevel::kError, "journal_log_kept", {{"journal", path_}, {"log", kept}});
    walk_ = {};
  }
  return LookIntoDatabase();
}

absl::Status Opener::LookIntoDatabase() {
  if (absl::Status s = MakeDatabaseFile(path_); !s.ok()) return s;
  absl::StatusOr<Connection> connection = Connection::Open(path_, vfs_);
  if (!connection.ok()) return connection.status();
  out_.connection = *std::move(connection);
  out_.connection.MoveLogAtEnd(false);  // until it is known to be valid
  const auto version = NumberOf(out_.connection, "PRAGMA user_version");
  if (!version.ok()) return version.status();
  version_ = *version;
  if (absl::Status s = CheckSchema(version_, SchemasOfJournals()); !s.ok()) return s;
  const auto tables = NumberOf(out_.connection, "SELECT count(*) FROM sqlite_schema");
  if (!tables.ok()) return tables.status();
  is_new_ = version_ == 0;
  if (is_new_ && *tables > 0) {
    return absl::FailedPreconditionError(
        "it is no journal: it has tables, but no schema's number; move it out of the data folder");
  }
  if (is_new_) return absl::OkStatus();
  auto id = JournalIdOf(out_.connection);
  if (!id.ok()) return id.status();
  id_ = *std::move(id);
  return absl::OkStatus();
}

// ------------------------------------------------------------------ record

absl::Status Opener::TakeRecord() {
  absl::StatusOr<std::unique_ptr<HeadsFile>> heads = HeadsFile::Open(folder_);
  if (heads.ok()) {
    out_.heads = *std::move(heads);
    if (out_.heads->unreadable() > 0) {
      Log(LogLevel::kError, "heads_damaged",
          {{"journal", path_}, {"slots", out_.heads->unreadable()}});
    }
    return CheckSameJournal();
  }
  if (absl::IsUnavailable(heads.status())) return heads.status();
  if (absl::IsDataLoss(heads.status())) {
    Log(LogLevel::kError, "heads_damaged",
        {{"journal", path_}, {"error", heads.status().message()}});
  }
  const bool had_record = !is_new_ && format_ == DatabaseFormat::kWithLog;
  return MakeRecord(id_.empty() ? RandomJournalId() : id_,
                    had_record || walk_.damaged() ? State::kUnconfirmed : State::kThere);
}

absl::Status Opener::MakeRecord(const std::string& id, State state) {
  const bool doubt = state == State::kUnconfirmed;
  Taking taking = Taking::kNo;
  std::vector<RecordedHead> heads;
  if (is_new_) {
    taking = doubt ? Taking::kInDoubt : Taking::kYes;
  } else {
    const auto found = FindMeshes(out_.connection, {});
    if (!found.ok()) return found.status();
    for (const FoundMesh& mesh : *found) {
      heads.push_back(mesh.head);
      heads.back().state = state;
    }
  }
  auto made = HeadsFile::Make(folder_, id, heads, taking);
  if (!made.ok()) return made.status();
  out_.heads = *std::move(made);
  if (is_new_) return absl::OkStatus();
  const char* const message =
      doubt ? "nothing tells what was acknowledged: a copy of journal.sqlite alone is no backup"
            : "a backup: taken over as it is";
  Log(doubt ? LogLevel::kError : LogLevel::kInfo, "heads_made",
      {{"journal", path_}, {"message", message}});
  return absl::OkStatus();
}

absl::Status Opener::CheckSameJournal() {
  const std::string recorded = out_.heads->journal();
  const bool taking = out_.heads->taking() != Taking::kNo;
  if (is_new_ || id_ == recorded || (id_.empty() && taking)) return absl::OkStatus();
  const std::string code = absl::StrFormat(
      "%08x",
      static_cast<std::uint32_t>(RowSumOf(absl::string_view(recorded), absl::string_view(id_))));
  if (!IsAccepted(code)) {
    return absl::FailedPreconditionError(absl::StrCat(
        HeadsFile::kFileName, " beside it is the record of another journal, with ",
        out_.heads->Heads().size(),
        " meshes: the files of two folders are mixed up, or a backup was put over a journal. Put "
        "together what belongs together; a backup goes into an empty folder. To take over what "
        "is there, start the server with --accept-loss=",
        code));
  }
  Log(LogLevel::kWarning, "loss_accepted", {{"journal", path_}, {"accepted", code}});
  out_.heads.reset();
  return MakeRecord(id_.empty() ? RandomJournalId() : id_, State::kThere);
}

// ------------------------------------------------------------------ losses

// Reads the whole database, so it is done only after another fault was found.
absl::Status Opener::CheckStructure() {
  Statement check(out_.connection, "PRAGMA quick_check(1)");
  const bool row = check.Step();
  if (absl::IsUnavailable(check.status())) return check.status();
  const std::string found = row ? check.Bytes(0) : std::string(check.status().message());
  if (found == "ok") return absl::OkStatus();
  out_.sealed = absl::DataLossError(
      absl::StrCat("the database is damaged (", Printable(found),
                   "): the journal is read only. Export what is left, and restore a backup"));
  return absl::OkStatus();
}

// True if the log shows lost transactions and the record is older than these, as is possible after
// a loss of power.
bool Opener::LogSaysMore() const {
  if (!walk_.damaged()) return false;
  const HeadsFile::Position known = out_.heads->position();
  return known.salt != walk_.salt || known.frames < walk_.shown;
}

absl::Status Opener::Compare() {
  HeadsFile& heads = *out_.heads;
  auto found = FindMeshes(out_.connection, heads.Heads());
  if (!found.ok()) return found.status();
  found_ = *std::move(found);
  const Taking taking = heads.taking();
  if (taking != Taking::kNo) {
    for (FoundMesh& mesh : found_) {
      mesh.head.state = taking == Taking::kInDoubt ? State::kUnconfirmed : State::kThere;
      mesh.sum_on_record = mesh.head.sum;
      if (absl::Status s = heads.Put(mesh.head); !s.ok()) return s;
    }
    if (absl::Status s = heads.TookOver(); !s.ok()) return s;
  }
  if (absl::Status s = BringUpToDate(taking == Taking::kNo && LogSaysMore()); !s.ok()) return s;
  out_.losses = FindLosses(heads.Heads(), heads.confirmed(), found_);
  return absl::OkStatus();
}

// Brings a record up to date that is behind the journal because the server was killed. A failed
// write matters only in doubt, or if there are losses.
absl::Status Opener::BringUpToDate(bool doubt) {
  HeadsFile& heads = *out_.heads;
  std::set<HeadsFile::Key> lost;
  for (const Loss& loss : FindLosses(heads.Heads(), heads.confirmed(), found_)) {
    lost.insert(loss.key());
  }
  std::map<HeadsFile::Key, RecordedHead> recorded;
  for (const RecordedHead& head : heads.Heads()) recorded.emplace(head.key, head);
  absl::Status status;
  for (FoundMesh& mesh : found_) {
    RecordedHead head = mesh.head;
    const auto record = recorded.find(head.key);
    if (record != recorded.end()) head.id = record->second.id;
    head.state = doubt ? State::kUnconfirmed : State::kThere;
    const bool same = record != recorded.end() && record->second == head;
    recorded.erase(head.key);
    if (same || lost.contains(head.key)) continue;
    status.Update(heads.Put(head));
    mesh.sum_on_record = head.sum;
  }
  for (const auto& [key, head] : recorded) {
    if (!lost.contains(key)) status.Update(heads.Forget(key));  // its deletion was completed
  }
  // The frames shown by the log have been checked.
  const HeadsFile::Position log{walk_.salt, std::max(walk_.taken, walk_.shown)};
  const HeadsFile::Position known = heads.position();
  const bool newer = log.salt != known.salt || log.frames > known.frames;
  if (log.salt != 0 && newer) heads.Publish(log);
  status.Update(heads.Sync());
  return doubt || !lost.empty() ? status : absl::OkStatus();
}

absl::Status Opener::Accept() {
  if (out_.losses.empty()) return absl::OkStatus();
  const bool all = IsAccepted(CodeOf(out_.losses));
  std::vector<Loss> left;
  for (Loss& loss : out_.losses) {
    if (!all && !IsAccepted(loss.Acceptance())) {
      left.push_back(std::move(loss));
      continue;
    }
    RecordedHead head = loss.found;
    head.state = State::kThere;
    if (loss.recorded.key != 0 && loss.kind != Loss::Kind::kOther) head.id = loss.recorded.id;
    absl::Status status = head.key == 0 ? out_.heads->Forget(loss.key()) : out_.heads->Put(head);
    if (!status.ok()) return status;
    Log(LogLevel::kWarning, "loss_accepted",
        {{"mesh", loss.name},
         {"key", loss.key()},
         {"accepted", loss.Acceptance()},
         {"acknowledged", loss.recorded.revision}});
  }
  out_.losses = std::move(left);
  return out_.heads->Sync();
}

// ------------------------------------------------------------------ preparation for writing

// Keeps a copy of a damaged log, and moves into the database what SQLite accepts of it, so that its
// rest does not stand behind later frames.
absl::Status Opener::SetLogAside() {
  if (!walk_.damaged()) return absl::OkStatus();
  const std::string kept =
      absl::StrCat(folder_, "/journal.damaged-", absl::Hex(walk_.salt, absl::kZeroPad16), ".wal");
  std::error_code error;
  fs::copy_file(log_path_, kept, fs::copy_options::skip_existing, error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("cannot copy the damaged log to ", kept, ": ", error.message()));
  }
  Log(LogLevel::kError, "journal_log_damaged",
      {{"journal", path_},
       {"frames", walk_.taken},
       {"of", walk_.shown},
       {"kept", kept},
       {"message", "the log is damaged before its end: a disk, or a copy, changed it"}});
  if (!out_.sealed.ok()) return absl::OkStatus();
  return out_.connection.Run("PRAGMA wal_checkpoint(TRUNCATE)");
}

absl::Status Opener::Prepare() {
  out_.connection.MoveLogAtEnd(true);
  if (absl::Status s = PrepareJournal(out_.connection, path_, out_.heads->journal()); !s.ok()) {
    return s;
  }
  if (version_ == kJournalSchema) return absl::OkStatus();
  // So that a copy without the log differs from a new journal.
  return out_.connection.Run("PRAGMA wal_checkpoint(PASSIVE)");
}

void Opener::TellWhatWasMade() const {
  if (!is_new_) return;
  const std::string others = OtherFilesIn(folder_);
  const bool odd =
      !others.empty() || format_ != DatabaseFormat::kNone || !out_.heads->Heads().empty();
  Log(odd ? LogLevel::kWarning : LogLevel::kInfo, "journal_made",
      {{"journal", path_},
       {"others", others},
       {"message",
        odd ? "a new journal, though the folder is not empty; a backup is read if it is called "
              "journal.sqlite, and a copy of journal.sqlite without its log is no backup"
            : "a new journal"}});
}

void Opener::TellLosses() const {
  if (!out_.sealed.ok()) {
    Log(LogLevel::kError, "journal_sealed", {{"journal", path_}, {"error", out_.sealed.message()}});
  }
  for (const Loss& loss : out_.losses) {
    Log(LogLevel::kError, "mesh_loss",
        {{"mesh", loss.name},
         {"key", loss.key()},
         {"acknowledged",
          loss.kind == Loss::Kind::kUnconfirmed ? "unknown" : absl::StrCat(loss.recorded.revision)},
         {"found", loss.found.key == 0 ? "none" : absl::StrCat(loss.found.revision)},
         {"accept", absl::StrCat("--accept-loss=", loss.Acceptance())},
         {"message", loss.Text()}});
  }
  if (out_.losses.empty() || !out_.sealed.ok()) return;
  Log(LogLevel::kError, "journal_losses",
      {{"journal", path_},
       {"meshes", out_.losses.size()},
       {"accept_all", absl::StrCat("--accept-loss=", CodeOf(out_.losses))}});
}

}  // namespace

absl::StatusOr<OpenedJournal> OpenJournalFiles(const std::string& folder, const char* vfs,
                                               const std::vector<std::string>& accepted) {
  return Opener(folder, vfs, accepted).Open();
}

}  // namespace dynmesh::server
