#include "server/journal/heads_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/log.h"
#include "server/journal/heads_slot.h"

namespace dynmesh::server {
namespace {

using heads::AddNumber;
using heads::FindSlot;
using heads::FoundSlot;
using heads::kBlockBytes;
using heads::kSlotsInBlock;
using heads::SlotReader;

constexpr char kHeadsMagic[] = "dynmesh heads 1\n";
constexpr std::chrono::seconds kBetweenSyncs{1};

absl::Status Failed(absl::string_view doing) {
  return absl::UnavailableError(
      absl::StrCat(doing, " ", HeadsFile::kFileName, ": ", std::strerror(errno)));
}

}  // namespace

// ------------------------------------------------------------------ the file

absl::StatusOr<std::unique_ptr<HeadsFile>> HeadsFile::Open(const std::string& folder) {
  const std::string path = absl::StrCat(folder, "/", kFileName);
  const int file = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0 && errno == ENOENT) return absl::NotFoundError(absl::StrCat("no ", path));
  if (file < 0) return Failed("opening");
  std::unique_ptr<HeadsFile> heads(new HeadsFile(file));
  {
    const MutexLock lock(heads->mutex_);
    if (absl::Status s = heads->Load(); !s.ok()) return s;
  }
  heads->StartSyncing();
  return heads;
}

absl::StatusOr<std::unique_ptr<HeadsFile>> HeadsFile::Make(const std::string& folder,
                                                           const std::string& journal,
                                                           const std::vector<Head>& heads,
                                                           Taking taking) {
  const std::string path = absl::StrCat(folder, "/", kFileName), fresh = path + ".new";
  const int file = open(fresh.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0) return Failed("making");
  std::unique_ptr<HeadsFile> made(new HeadsFile(file));
  made->journal_ = journal;
  absl::Status status;
  {
    const MutexLock lock(made->mutex_);
    made->taking_ = taking;
    for (const Head& head : heads) {
      if (status.ok()) status = made->PutNow(head);
    }
    // The heads become durable together with the header.
    made->confirmed_ = made->greatest_;
    for (int copy = 0; status.ok() && copy < 2; ++copy) status = made->WriteHeader();
  }
  if (status.ok()) status = made->Sync();
  if (!status.ok()) return status;
  if (std::rename(fresh.c_str(), path.c_str()) != 0) return Failed("renaming");
  const int parent = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool durable = parent >= 0 && fsync(parent) == 0;
  if (parent >= 0) close(parent);
  if (!durable) return Failed("syncing the folder of");
  made->StartSyncing();
  return made;
}

HeadsFile::~HeadsFile() {
  if (thread_.joinable()) {
    {
      const MutexLock lock(mutex_);
      stopping_ = true;
    }
    wake_.NotifyAll();
    thread_.join();
    (void)Sync();  // a failure is logged
  }
  close(file_);
}

absl::Status HeadsFile::Load() {
  std::string bytes(static_cast<std::size_t>(std::max<off_t>(0, lseek(file_, 0, SEEK_END))), '\0');
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = pread(file_, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
    if (n < 0) return Failed("reading");
    if (n == 0) break;
    at += static_cast<std::size_t>(n);
  }
  if (!LoadHeader(bytes)) {
    return absl::DataLossError(absl::StrCat(kFileName, " is damaged: it has no header"));
  }
  const std::size_t blocks = (bytes.size() + kBlockBytes - 1) / kBlockBytes;
  const std::size_t slots = (blocks + 1) / 2 * kSlotsInBlock;
  slots_.resize(std::max<std::size_t>(1, slots));
  for (std::size_t slot = 1; slot < slots_.size(); ++slot) LoadSlot(slot, bytes);
  return absl::OkStatus();
}

bool HeadsFile::LoadHeader(const std::string& bytes) {
  const std::optional<FoundSlot> found = FindSlot(0, bytes);
  if (!found.has_value() || found->blank) return false;
  SlotReader reader(found->content);
  if (reader.Bytes(sizeof(kHeadsMagic) - 1) != kHeadsMagic) return false;
  journal_ = reader.Bytes(kIdBytes);
  confirmed_ = greatest_ = reader.Signed();
  position_.salt = reader.Number();
  position_.frames = reader.Number();
  taking_ = static_cast<Taking>(reader.Byte());
  sequence_ = found->sequence;
  slots_[0].copy = found->copy;
  return true;
}

void HeadsFile::LoadSlot(std::size_t slot, const std::string& bytes) {
  const std::optional<FoundSlot> found = FindSlot(slot, bytes);
  if (!found.has_value()) ++unreadable_;
  if (!found.has_value() || found->blank) return free_.push_back(slot);
  sequence_ = std::max(sequence_, found->sequence);
  slots_[slot].copy = found->copy;
  Head& head = slots_[slot].head;
  SlotReader reader(found->content);
  head.key = reader.Signed();
  head.revision = reader.Number();
  head.sum = reader.Signed();
  head.requests = reader.Signed();
  head.state = static_cast<State>(reader.Byte());
  const std::size_t size = reader.Byte();
  head.id = reader.Bytes(std::min(size, kMaxNameBytes));
  greatest_ = std::max(greatest_, head.key);
  // No mesh has two slots. If one does, the slot with more is used.
  if (head.key != 0) {
    const auto [place, is_new] = places_.emplace(head.key, slot);
    if (is_new || slots_[place->second].head.revision >= head.revision) return;
    place->second = slot;
    return;
  }
  free_.push_back(slot);
}

absl::Status HeadsFile::Write(std::size_t slot, const std::string& content) {
  const int copy = 1 - slots_[slot].copy;
  const std::size_t at = heads::OffsetOf(slot, copy);
  const std::string bytes = heads::EncodeSlot(at, ++sequence_, content);
  dirty_ = true;
  const ssize_t n = pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(at));
  if (n != static_cast<ssize_t>(bytes.size())) {
    if (n >= 0) errno = ENOSPC;
    return Failed("writing");
  }
  slots_[slot].copy = copy;
  return absl::OkStatus();
}

absl::Status HeadsFile::WriteHeader() {
  std::string content = kHeadsMagic;
  content += journal_;
  AddNumber(static_cast<std::uint64_t>(confirmed_), &content);
  AddNumber(position_.salt, &content);
  AddNumber(position_.frames, &content);
  content.push_back(static_cast<char>(taking_));
  return Write(0, content);
}

absl::Status HeadsFile::WriteHead(std::size_t slot) {
  const Head& head = slots_[slot].head;
  std::string content;
  AddNumber(static_cast<std::uint64_t>(head.key), &content);
  AddNumber(head.revision, &content);
  AddNumber(static_cast<std::uint64_t>(head.sum), &content);
  AddNumber(static_cast<std::uint64_t>(head.requests), &content);
  content.push_back(static_cast<char>(head.state));
  const std::string id = head.id.substr(0, kMaxNameBytes);
  content.push_back(static_cast<char>(id.size()));
  absl::Status status = Write(slot, content + id);
  if (status.ok()) {
    unwritten_.erase(slot);
  } else {
    unwritten_.insert(slot);
  }
  return status;
}

// ------------------------------------------------------------------ content

HeadsFile::Taking HeadsFile::taking() const {
  const MutexLock lock(mutex_);
  return taking_;
}

absl::Status HeadsFile::TookOver() {
  {
    const MutexLock lock(mutex_);
    taking_ = Taking::kNo;
    if (absl::Status s = WriteHeader(); !s.ok()) return s;
  }
  return Sync();
}

HeadsFile::Position HeadsFile::position() const {
  const MutexLock lock(mutex_);
  return position_;
}

HeadsFile::Key HeadsFile::confirmed() const {
  const MutexLock lock(mutex_);
  return confirmed_;
}

HeadsFile::Key HeadsFile::greatest() const {
  const MutexLock lock(mutex_);
  return greatest_;
}

std::vector<HeadsFile::Head> HeadsFile::Heads() const {
  const MutexLock lock(mutex_);
  std::vector<Head> heads;
  for (const auto& [key, slot] : places_) heads.push_back(slots_[slot].head);
  return heads;
}

// ------------------------------------------------------------------ changes

HeadsFile::Head* HeadsFile::Staged(Key mesh) {
  const auto staged = std::find_if(staged_.begin(), staged_.end(),
                                   [mesh](const Head& head) { return head.key == mesh; });
  if (staged != staged_.end()) return &*staged;
  const MutexLock lock(mutex_);
  const auto place = places_.find(mesh);
  if (place == places_.end()) return nullptr;
  staged_.push_back(slots_[place->second].head);
  return &staged_.back();
}

void HeadsFile::Stage(const Head& head) { staged_.push_back(head); }

void HeadsFile::StageEntry(Key mesh, std::uint64_t revision, std::int64_t sum) {
  if (Head* const head = Staged(mesh)) {
    head->revision = revision;
    head->sum = sum;
  }
}

void HeadsFile::StageRequest(Key mesh, std::int64_t number) {
  if (Head* const head = Staged(mesh)) head->requests = number;
}

void HeadsFile::Publish(const Position& position) {
  const MutexLock lock(mutex_);
  absl::Status status;
  const std::set<std::size_t> again = unwritten_;
  for (const std::size_t slot : again) status.Update(WriteHead(slot));
  for (const Head& staged : staged_) {
    const auto place = places_.find(staged.key);
    Head head = staged;
    // A deletion may have begun since it was staged.
    if (place != places_.end()) head.state = slots_[place->second].head.state;
    status.Update(PutNow(head));
  }
  staged_.clear();
  position_ = position;
  status.Update(WriteHeader());
  Told(status);
  wake_.NotifyOne();
}

absl::Status HeadsFile::PutNow(const Head& head) {
  auto place = places_.find(head.key);
  const bool is_new = place == places_.end();
  if (is_new) {
    if (free_.empty()) {
      const std::size_t slots = slots_.size();
      slots_.resize((slots + kSlotsInBlock - 1) / kSlotsInBlock * kSlotsInBlock + kSlotsInBlock);
      for (std::size_t slot = slots_.size(); slot-- > slots;) free_.push_back(slot);
    }
    place = places_.emplace(head.key, free_.back()).first;
    free_.pop_back();
  }
  slots_[place->second].head = head;
  greatest_ = std::max(greatest_, head.key);
  const std::size_t slot = place->second;
  const absl::Status status = WriteHead(slot);
  return status.ok() && is_new ? WriteHead(slot) : status;  // new: overwrite both copies
}

absl::Status HeadsFile::ForgetNow(Key mesh) {
  const auto place = places_.find(mesh);
  if (place == places_.end()) return absl::OkStatus();
  const std::size_t slot = place->second;
  slots_[slot].head = {};
  places_.erase(place);
  free_.push_back(slot);
  return WriteHead(slot);
}

absl::Status HeadsFile::Put(const Head& head) {
  const MutexLock lock(mutex_);
  return PutNow(head);
}

absl::Status HeadsFile::Forget(Key mesh) {
  const MutexLock lock(mutex_);
  return ForgetNow(mesh);
}

absl::Status HeadsFile::BeginDelete(Key mesh) {
  const MutexLock lock(mutex_);
  const auto place = places_.find(mesh);
  if (place == places_.end()) return absl::OkStatus();
  const std::size_t slot = place->second;
  slots_[slot].head.state = State::kDeleting;
  absl::Status status = WriteHead(slot);
  if (status.ok()) status = SyncNow();
  return status;
}

void HeadsFile::EndDelete(Key mesh) {
  const MutexLock lock(mutex_);
  Told(ForgetNow(mesh));
  wake_.NotifyOne();
}

// ------------------------------------------------------------------ syncs

void HeadsFile::Told(const absl::Status& status) {
  if (!status.ok() && !failing_) {
    Log(LogLevel::kWarning, "heads_failed",
        {{"error", status.message()},
         {"message",
          "edits go on; until it can be written again, a loss of what was acknowledged since "
          "may not be noticed"}});
  } else if (status.ok() && failing_) {
    Log(LogLevel::kInfo, "heads_work_again", {{"file", kFileName}});
  }
  failing_ = !status.ok();
}

absl::Status HeadsFile::SyncNow() {
  const Key greatest = unwritten_.empty() ? greatest_ : confirmed_;
  dirty_ = false;
  const auto sync = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) -> absl::Status {
    mutex_.Unlock();
    const bool done = fdatasync(file_) == 0;
    const int error = errno;
    mutex_.Lock();
    errno = error;
    return done ? absl::OkStatus() : Failed("syncing");
  };
  absl::Status status = sync();
  if (status.ok() && greatest > confirmed_) {
    confirmed_ = greatest;
    status = WriteHeader();
    dirty_ = false;
    if (status.ok()) status = sync();
  }
  return status;
}

absl::Status HeadsFile::Sync() {
  const MutexLock lock(mutex_);
  if (!dirty_) return absl::OkStatus();
  const absl::Status status = SyncNow();
  Told(status);
  return status;
}

void HeadsFile::StartSyncing() {
  thread_ = std::thread([this] { Run(); });
}

void HeadsFile::Run() {
  const MutexLock lock(mutex_);
  while (true) {
    wake_.Wait(mutex_,
               [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_ || dirty_; });
    if (stopping_) return;
    if (absl::Status s = SyncNow(); !s.ok()) Told(s);
    wake_.WaitFor(mutex_, kBetweenSyncs,
                  [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopping_; });
  }
}

}  // namespace dynmesh::server
