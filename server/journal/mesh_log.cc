#include "server/journal/mesh_log.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "proto/codec/journal_codec.h"
#include "server/base/log.h"
#include "server/base/mesh_name.h"

namespace dynmesh::server {
namespace {

std::int64_t Milliseconds(double seconds) { return static_cast<std::int64_t>(seconds * 1e3); }

}  // namespace

MeshLog::MeshLog(Journal* journal, Journal::Key key, std::string id, int dimension,
                 const Sizes& sizes, const Limits& limits)
    : journal_(journal),
      key_(key),
      id_(std::move(id)),
      dimension_(dimension),
      limits_(limits),
      book_(std::make_shared<Book>(id_)) {
  book_->sizes = sizes;
}

absl::Status MeshLog::Append(std::span<const Batch> batches) {
  std::vector<Journal::Entry> entries;
  std::vector<Journal::Request> requests;
  for (const Batch& batch : batches) {
    const RequestMemory::Entry& answer = batch.answer;
    if (answer.from_revision != answer.to_revision) {
      entries.push_back(
          {answer.to_revision, codec::EncodeJournalEntry(*batch.edits, answer.hash, dimension_)});
    }
    if (!batch.request_id.empty()) {
      requests.push_back(
          {std::string(batch.request_id),
           codec::EncodeJournalAnswer({answer.content.a, answer.content.b, answer.from_revision,
                                       answer.to_revision, answer.hash, answer.work})});
    }
  }
  if (entries.empty() && requests.empty()) return absl::OkStatus();
  if (absl::Status status = journal_->Append(key_, entries, requests); !status.ok()) {
    owns_ = OutcomeOf(status) == AppendOutcome::kRefused;
    return JournalError(status, id_);
  }
  const MutexLock lock(book_->mutex);
  auto entry = entries.begin();
  for (const Batch& batch : batches) {
    if (batch.answer.from_revision == batch.answer.to_revision) continue;
    book_->sizes.Add(entry->revision, entry->data.size(), batch.answer.work);
    book_->last = entry->revision;
    ++entry;
  }
  return absl::OkStatus();
}

void MeshLog::SawEntry(std::uint64_t revision, std::uint64_t bytes, const WorkCounters& work) {
  const MutexLock lock(book_->mutex);
  book_->sizes.Add(revision, bytes, work);
}

void MeshLog::SawSnapshot(std::uint64_t bytes) {
  const MutexLock lock(book_->mutex);
  book_->sizes = {.snapshot = bytes};
}

absl::Status MeshLog::AppendOtherBits(const DynamicMesh& mesh) {
  const EditBatch none;
  Batch batch;
  batch.edits = &none;
  batch.answer.from_revision = mesh.revision() - 1;
  batch.answer.to_revision = mesh.revision();
  batch.answer.hash = mesh.hash();
  if (absl::Status status = Append({&batch, 1}); !status.ok()) return status;
  // By this thread: clients wait for the mesh.
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [start] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  Snapshots::Made made;
  const std::vector<Feature> features = mesh.Features();
  made.take = seconds();
  const std::vector<std::string> parts =
      codec::EncodeJournalSnapshot(features, mesh.hash(), dimension_);
  made.encode = seconds() - made.take;
  for (const std::string& part : parts) made.bytes += part.size();
  made.status = journal_->Compact(key_, mesh.revision(), parts, *book_->ended);
  made.write = seconds() - made.take - made.encode;
  Sizes then;
  {
    const MutexLock lock(book_->mutex);
    then = book_->sizes;
  }
  Take(*book_, then, mesh.revision(), made);
  return absl::OkStatus();
}

// ------------------------------------------------------------------ snapshots

bool MeshLog::IsDue(const DynamicMesh& mesh) const {
  const MutexLock lock(book_->mutex);
  const Sizes sizes = book_->sizes;
  if (book_->making || book_->last == 0 || sizes.entries < 2 * book_->failed_at) return false;
  if (sizes.entries > std::max(limits_.bytes, sizes.snapshot)) return true;
  return sizes.operations > limits_.operations && sizes.operations > 2 * mesh.Stats().operations;
}

bool MeshLog::needs_features() const {
  const MutexLock lock(book_->mutex);
  return book_->unreadable;
}

void MeshLog::OrderSnapshot(Snapshots& snapshots) { Order(snapshots, std::nullopt); }

void MeshLog::OrderSnapshot(Snapshots& snapshots, const DynamicMesh& mesh) {
  Order(snapshots, FeaturesAt{mesh.revision(), mesh.hash(), mesh.Features()});
}

void MeshLog::Order(Snapshots& snapshots, std::optional<FeaturesAt> features) {
  Snapshots::Order order;
  Sizes then;
  {
    const MutexLock lock(book_->mutex);
    book_->making = true;
    order.revision = book_->last;
    then = book_->sizes;
  }
  order.key = key_;
  order.dimension = dimension_;
  order.features = std::move(features);
  order.ended = book_->ended;
  order.done = [book = book_, then, revision = order.revision](const Snapshots::Made& made) {
    Take(*book, then, revision, made);
  };
  snapshots.Make(std::move(order));
}

void MeshLog::Take(Book& book, const Sizes& then, std::uint64_t revision,
                   const Snapshots::Made& made) {
  {
    const MutexLock lock(book.mutex);
    book.making = false;
    book.unreadable = made.unreadable;
    if (made.status.ok()) {
      book.sizes = {.snapshot = made.bytes,
                    .entries = book.sizes.entries - then.entries,
                    .operations = book.sizes.operations - then.operations};
    }
    // What cannot be read is made from the mesh at once.
    book.failed_at = made.status.ok() || made.unreadable ? 0 : then.entries;
  }
  if (made.status.ok()) {
    Log(LogLevel::kInfo, "compacted",
        {{"mesh", book.id},
         {"revision", revision},
         {"entry_bytes", then.entries},
         {"operations", then.operations},
         {"snapshot_bytes", made.bytes},
         {"take_milliseconds", Milliseconds(made.take)},
         {"encode_milliseconds", Milliseconds(made.encode)},
         {"write_milliseconds", Milliseconds(made.write)}});
  } else if (!*book.ended) {
    Log(LogLevel::kWarning, "compact_failed",
        {{"mesh", book.id}, {"revision", revision}, {"error", made.status.message()}});
  }
}

}  // namespace dynmesh::server
