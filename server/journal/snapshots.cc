#include "server/journal/snapshots.h"

#include <chrono>
#include <future>
#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/journal_codec.h"
#include "server/journal/past_features.h"

namespace dynmesh::server {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

absl::Status NotWanted() {
  return absl::CancelledError("the mesh was closed while its snapshot was made");
}

}  // namespace

Snapshots::Snapshots(Journal* journal, std::function<void(const Made&)> observe)
    : journal_(journal), observe_(std::move(observe)) {}

void Snapshots::Make(Order order) {
  {
    const MutexLock lock(mutex_);
    if (!stopped_) {
      orders_.insert(order.ended);
      taker_.Post([this, shared = std::make_shared<Order>(std::move(order))] {
        const Made made = Work(*shared);
        if (made.status.ok() && observe_ != nullptr) observe_(made);
        shared->done(made);
        const MutexLock done(mutex_);
        orders_.erase(shared->ended);
        idle_.NotifyAll();
      });
      return;
    }
  }
  Made made;
  made.status = NotWanted();
  order.done(made);
}

void Snapshots::Wait() {
  const MutexLock lock(mutex_);
  idle_.Wait(mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return orders_.empty(); });
}

void Snapshots::Stop() {
  {
    const MutexLock lock(mutex_);
    stopped_ = true;
    for (const auto& ended : orders_) *ended = true;
  }
  taker_.Stop();
  writer_.Stop();
}

Snapshots::Made Snapshots::Work(Order& order) {
  Made made;
  std::vector<std::string> parts;
  made.status = *order.ended ? NotWanted() : Take(order, &parts, &made);
  order.features.reset();
  if (!made.status.ok()) return made;
  for (const std::string& part : parts) made.bytes += part.size();
  const auto start = Clock::now();
  made.status = Write(order, parts);
  made.write = SecondsSince(start);
  return made;
}

absl::Status Snapshots::Take(const Order& order, std::vector<std::string>* parts,
                             Made* made) const {
  const auto start = Clock::now();
  const auto encode = [&](std::span<const Feature* const> features, const MeshHash& hash) {
    made->take = SecondsSince(start);
    *parts = codec::EncodeJournalSnapshot(features, hash, order.dimension, *order.ended);
    made->encode = SecondsSince(start) - made->take;
    return *order.ended ? NotWanted() : absl::OkStatus();
  };
  if (order.features.has_value()) {
    std::vector<const Feature*> features;
    features.reserve(order.features->features.size());
    for (const Feature& feature : order.features->features) features.push_back(&feature);
    return encode(features, order.features->hash);
  }
  PastFeatures past(order.dimension, MeshHash(), order.ended.get());
  absl::Status status = ReadBack(order, past);
  if (status.ok() && past.revision() != order.revision) {
    status = absl::DataLossError(
        absl::StrCat("the journal ends at revision ", past.revision(), ", not ", order.revision));
  }
  if (status.ok() && past.bits() != kMeshBits) {
    status = absl::DataLossError(absl::StrCat("revision ", order.revision, " has the bits ",
                                              past.bits(), ", not ", kMeshBits));
  }
  made->unreadable = absl::IsDataLoss(status);
  return status.ok() ? encode(past.features().Ordered(), past.hash()) : status;
}

// All rows first: a thread of low priority may decode them for long, and an open transaction keeps
// SQLite's log from starting anew, and PostgreSQL ends it.
absl::Status Snapshots::ReadBack(const Order& order, PastFeatures& past) const {
  std::vector<std::string> parts;
  std::vector<Journal::Entry> entries;
  std::uint64_t base = 0;
  const auto wanted = [&] { return *order.ended ? NotWanted() : absl::OkStatus(); };
  Journal::Visitor visitor;
  visitor.snapshot = [&](std::uint64_t revision, const std::string& part) {
    base = revision;
    parts.push_back(part);
    return wanted();
  };
  visitor.entry = [&](const Journal::Entry& entry) {
    entries.push_back(entry);
    return wanted();
  };
  absl::Status status = journal_->ReadPast(order.key, order.revision, order.revision, visitor);
  for (std::string& part : parts) {
    if (status.ok()) status = past.AddPart(base, part);
    std::string().swap(part);
  }
  for (Journal::Entry& entry : entries) {
    if (status.ok()) status = past.Apply(entry);
    std::string().swap(entry.data);
  }
  return status;
}

// By the thread of normal priority; this one waits, so that there is one snapshot at a time.
absl::Status Snapshots::Write(const Order& order, const std::vector<std::string>& parts) {
  std::promise<absl::Status> written;
  writer_.Post([&] {
    written.set_value(journal_->Compact(order.key, order.revision, parts, *order.ended));
  });
  return written.get_future().get();
}

}  // namespace dynmesh::server
