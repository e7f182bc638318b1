#include "server/journal/journal_copy.h"

#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "proto/codec/journal_codec.h"
#include "server/base/log.h"
#include "server/journal/journal_errors.h"
#include "server/journal/mesh_import.h"
#include "server/journal/row_sum.h"
#include "server/journal/whole_reading.h"

namespace dynmesh::server {
namespace {

using Mesh = Journal::Mesh;
using Part = MeshImport::Part;

// A row costs more than its data.
constexpr std::uint64_t kRowBytes = 64;

// What a mesh has, to be compared: counts, and a checksum of all rows in their order.
struct Summary {
  std::uint64_t head = 0, parts = 0, entries = 0, requests = 0, bytes = 0;
  RowSum sum;

  void AddPart(std::uint64_t revision, const std::string& part) {
    Add(1, revision, part);
    head = revision;
    ++parts;
  }
  void AddEntry(const Journal::Entry& entry) {
    Add(2, entry.revision, entry.data);
    head = entry.revision;
    ++entries;
  }
  void AddRequest(const Journal::Request& request) {
    Add(3, 0, request.id);
    Add(4, 0, request.answer);
    ++requests;
  }
  bool Equals(const Summary& other) const {
    return head == other.head && parts == other.parts && entries == other.entries &&
           requests == other.requests && bytes == other.bytes && sum.value() == other.sum.value();
  }

 private:
  void Add(std::int64_t kind, std::uint64_t revision, const std::string& data) {
    sum.Add(kind).Add(static_cast<std::int64_t>(revision)).Add(absl::string_view(data));
    bytes += data.size();
  }
};

// Tells now and then how far the reading of a mesh is.
class Progress {
 public:
  Progress(const char* event, const std::string& mesh, absl::Duration interval)
      : event_(event), mesh_(mesh), interval_(interval), next_(absl::Now() + interval) {}
  void At(const Summary& summary) {
    if (absl::Now() < next_) return;
    next_ = absl::Now() + interval_;
    Log(LogLevel::kInfo, event_,
        {{"mesh", mesh_}, {"revision", summary.head}, {"bytes", summary.bytes}});
  }

 private:
  const char* const event_;
  const std::string& mesh_;
  const absl::Duration interval_;
  absl::Time next_;
};

absl::Status Named(const absl::Status& status, const std::string& mesh) {
  return absl::Status(status.code(), absl::StrCat("mesh ", mesh, ": ", status.message()));
}

// What is read back: a summary, and the hash of the last revision. Each revision has a hash.
struct Found {
  Summary summary;
  MeshHash hash;
};

absl::StatusOr<Found> ReadBack(Journal& journal, const Mesh& mesh, absl::Duration interval) {
  const absl::StatusOr<std::vector<std::uint64_t>> generations = GenerationsOf(journal, mesh.key);
  if (!generations.ok()) return generations.status();
  Found found;
  Progress progress("comparing", mesh.id, interval);
  const auto take = [&](const std::string& data) {
    progress.At(found.summary);
    const absl::StatusOr<MeshHash> hash = codec::DecodeJournalHash(data);
    if (hash.ok()) found.hash = *hash;
    return hash.status();
  };
  Journal::Visitor visitor;
  visitor.request = [&](const Journal::Request& request) {
    found.summary.AddRequest(request);
    return absl::OkStatus();
  };
  visitor.snapshot = [&](std::uint64_t revision, const std::string& part) {
    found.summary.AddPart(revision, part);
    return take(part);
  };
  visitor.entry = [&](const Journal::Entry& entry) {
    found.summary.AddEntry(entry);
    return take(entry.data);
  };
  const absl::Status status = ReadWhole(journal, mesh.key, *generations, visitor);
  if (!status.ok()) return status;
  return found;
}

// Takes the rows of a mesh from the source and writes them where no reader sees them.
class Writer {
 public:
  Writer(MeshImport& to, Journal::Key key, const Mesh& mesh, const CopyOptions& options)
      : to_(to),
        key_(key),
        options_(options),
        progress_("copying", mesh.id, options.report_interval) {
    whole_.id = mesh.id;
    whole_.description = mesh.description;
  }

  absl::Status Copy(Journal& from, Journal::Key mesh) {
    const absl::StatusOr<std::vector<std::uint64_t>> generations = GenerationsOf(from, mesh);
    if (!generations.ok()) return generations.status();
    for (const std::uint64_t revision : *generations) whole_.generations.push_back({revision});
    whole_.head = generations->front();
    Journal::Visitor visitor;
    visitor.request = [this](const Journal::Request& request) {
      summary_.AddRequest(request);
      whole_.requests.push_back(request);
      return absl::OkStatus();
    };
    visitor.snapshot = [this](std::uint64_t revision, const std::string& part) {
      return AddPart(revision, part);
    };
    visitor.entry = [this](const Journal::Entry& entry) { return AddEntry(entry); };
    absl::Status status = ReadWhole(from, mesh, *generations, visitor);
    if (status.ok()) status = Flush();
    return status.ok() ? to_.Publish(key_, whole_) : status;
  }

  const Summary& summary() const { return summary_; }

 private:
  absl::Status AddPart(std::uint64_t revision, const std::string& part) {
    while (whole_.generations[now_].revision < revision) ++now_;
    summary_.AddPart(revision, part);
    whole_.head = revision;
    MeshImport::Generation& generation = whole_.generations[now_];
    parts_.push_back({revision, static_cast<std::int64_t>(generation.parts++), part});
    generation.snapshot_bytes += part.size();
    return Waits(part.size());
  }
  absl::Status AddEntry(const Journal::Entry& entry) {
    summary_.AddEntry(entry);
    whole_.head = entry.revision;
    whole_.generations[now_].entry_bytes += entry.data.size();
    entries_.push_back(entry);
    return Waits(entry.data.size());
  }
  absl::Status Waits(std::uint64_t bytes) {
    progress_.At(summary_);
    waiting_ += bytes + kRowBytes;
    return waiting_ < options_.transaction_bytes ? absl::OkStatus() : Flush();
  }
  absl::Status Flush() {
    waiting_ = 0;
    if (parts_.empty() && entries_.empty()) return absl::OkStatus();
    absl::Status status = to_.WriteUnseen(key_, parts_, entries_);
    parts_.clear();
    entries_.clear();
    return status;
  }

  MeshImport& to_;
  const Journal::Key key_;
  const CopyOptions& options_;
  Progress progress_;
  MeshImport::Whole whole_;
  Summary summary_;
  std::size_t now_ = 0;  // the generation that is read
  std::vector<Part> parts_;
  std::vector<Journal::Entry> entries_;
  std::uint64_t waiting_ = 0;  // bytes of both
};

class Copier {
 public:
  Copier(Journal& from, Journal& to, const CopyOptions& options)
      : from_(from), to_(to), options_(options) {}

  absl::StatusOr<CopyCounts> Run() {
    absl::Status status = Choose();
    if (status.ok()) status = Compare();
    for (std::size_t i = 0; status.ok() && i < left_.size(); ++i) status = CopyOne(*left_[i]);
    if (!status.ok()) return status;
    return counts_;
  }

 private:
  // The meshes that are to be copied; claims them.
  absl::Status Choose() {
    if (to_.import() == nullptr) return absl::UnimplementedError("the target takes no meshes");
    absl::StatusOr<std::vector<Mesh>> all = from_.List();
    if (!all.ok()) return all.status();
    std::set<std::string> wanted(options_.meshes.begin(), options_.meshes.end());
    const bool takes_all = wanted.empty();
    for (Mesh& mesh : *all) {
      if (takes_all || wanted.erase(mesh.id) > 0) chosen_.push_back(std::move(mesh));
    }
    for (const std::string& missing : wanted) {
      return absl::NotFoundError(absl::StrCat(from_.name(), " has no mesh ", missing));
    }
    for (const Mesh& mesh : chosen_) {
      for (const absl::Status& wrong : {mesh.damage, mesh.loss}) {
        if (wrong.ok()) continue;
        return absl::DataLossError(absl::StrCat("mesh ", mesh.id, " of ", from_.name(), ": ",
                                                wrong.message(), "; or name the other meshes"));
      }
    }
    for (const Mesh& mesh : chosen_) {
      if (absl::Status s = from_.Claim(mesh.key); !s.ok()) return Named(s, mesh.id);
    }
    return absl::OkStatus();
  }

  // What the target has already is the same, or nothing is copied.
  absl::Status Compare() {
    const absl::StatusOr<std::vector<Mesh>> there = to_.List();
    if (!there.ok()) return there.status();
    std::map<std::string, const Mesh*> by_id;
    for (const Mesh& mesh : *there) by_id.emplace(mesh.id, &mesh);
    for (const Mesh& mesh : chosen_) {
      const auto it = by_id.find(mesh.id);
      if (it == by_id.end()) {
        left_.push_back(&mesh);
        continue;
      }
      const auto ours = ReadBack(from_, mesh, options_.report_interval);
      if (!ours.ok()) return Named(ours.status(), mesh.id);
      const auto other = ReadBack(to_, *it->second, options_.report_interval);
      if (!other.ok() || !ours->summary.Equals(other->summary) ||
          mesh.description != it->second->description) {
        return absl::AlreadyExistsError(
            absl::StrCat(to_.name(), " has another mesh ", mesh.id, " already (",
                         other.ok() ? absl::StrCat("revision ", other->summary.head,
                                                   "; the source has ", ours->summary.head)
                                    : std::string(other.status().message()),
                         "): nothing was copied. Delete it there, or name the other meshes"));
      }
      ++counts_.there;
      Count(ours->summary);
      Tell("mesh_there", mesh, *ours);
    }
    return absl::OkStatus();
  }

  absl::Status CopyOne(const Mesh& mesh) {
    const absl::StatusOr<Journal::Key> key = to_.import()->NewKey();
    if (!key.ok()) return key.status();
    Writer writer(*to_.import(), *key, mesh, options_);
    if (absl::Status s = writer.Copy(from_, mesh.key); !s.ok()) {
      Sweep(*key);
      return Named(s, mesh.id);
    }
    Mesh copy = mesh;
    copy.key = *key;
    const auto found = ReadBack(to_, copy, options_.report_interval);
    if (!found.ok() || !found->summary.Equals(writer.summary())) {
      const absl::Status deleted = to_.Delete(*key);
      if (deleted.ok()) Sweep(*key);
      return absl::DataLossError(absl::StrCat(
          "mesh ", mesh.id, " was read back from ", to_.name(), " otherwise than it was written",
          found.ok() ? "" : ": ", found.status().message(),
          deleted.ok() ? "; it was deleted there" : "; delete it there"));
    }
    ++counts_.copied;
    Count(found->summary);
    Tell("mesh_copied", mesh, *found);
    return absl::OkStatus();
  }

  void Sweep(Journal::Key key) {
    while (to_.Sweep(key)) {
    }
  }
  void Count(const Summary& summary) {
    counts_.revisions += summary.entries;
    counts_.bytes += summary.bytes;
  }
  void Tell(const char* event, const Mesh& mesh, const Found& found) const {
    const Summary& has = found.summary;
    Log(LogLevel::kInfo, event,
        {{"mesh", mesh.id},
         {"revision", has.head},
         {"hash", found.hash.ToHex()},
         {"entries", has.entries},
         {"requests", has.requests},
         {"bytes", has.bytes},
         {"done", counts_.copied + counts_.there},
         {"of", chosen_.size()}});
  }

  Journal& from_;
  Journal& to_;
  const CopyOptions& options_;
  std::vector<Mesh> chosen_;
  std::vector<const Mesh*> left_;  // of those, to be copied
  CopyCounts counts_;
};

}  // namespace

absl::StatusOr<CopyCounts> CopyMeshes(Journal& from, Journal& to, const CopyOptions& options) {
  return Copier(from, to, options).Run();
}

}  // namespace dynmesh::server
