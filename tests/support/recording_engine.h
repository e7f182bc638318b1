// An engine that executes nothing, for tests of single procedures of a program. A context records
// what is emitted, requested, read and subscribed to, at a time that the test chooses. Operations
// of a trace are what the test says; notifications mark them stale.
//
// Stamps are numbers: 0 is the beginning, and a lesser stamp is earlier.
#ifndef DYNMESH_TESTS_SUPPORT_RECORDING_ENGINE_H_
#define DYNMESH_TESTS_SUPPORT_RECORDING_ENGINE_H_

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/sac/engine.h"

namespace dynmesh::test {

// A request: what and when.
struct Requested {
  sac::Kind kind = 0;
  sac::Item item = 0;
  sac::Epoch epoch = 0;
  friend auto operator<=>(const Requested&, const Requested&) = default;
};

template <class Program>
class RecordingEngine {
 public:
  static constexpr bool kTraced = true;
  using Payload = typename sac::PayloadOf<Program>::Type;
  class Context;

  // An operation as executed last.
  struct Record {
    sac::Kind kind = 0;
    sac::Item item = 0;
    sac::Epoch epoch = 0;
    sac::Stamp stamp = 1;
    Payload payload = {};
    std::vector<sac::Output> outputs = {};
    std::vector<std::uint32_t> reads = {};
    sac::OpId next_of_item = sac::kNoOp;
    bool stale = false;
  };

  // --- For the test -------------------------------------------------------------------------

  // `head`: of the item's chain. Subscribes to the places.
  sac::OpId Add(Record record, sac::OpId& head, std::span<const sac::Place> places = {},
                bool attentive = false) {
    const auto id = static_cast<sac::OpId>(records_.size());
    record.next_of_item = std::exchange(head, id);
    records_.push_back(std::move(record));
    for (const sac::Place place : places) {
      subscriptions_.Add(place, id, sac::kAllParts, attentive);
    }
    return id;
  }
  // Those marked stale since the last call.
  std::vector<sac::OpId> TakeStale() {
    std::vector<sac::OpId> stale;
    for (sac::OpId id = 0; id < records_.size(); ++id) {
      if (std::exchange(records_[id].stale, false)) stale.push_back(id);
    }
    return stale;
  }
  // Requests of the environment.
  std::vector<Requested> requests;

  // --- As of sac::Engine --------------------------------------------------------------------

  sac::Stamp beginning() const { return 0; }
  bool Precedes(sac::Stamp a, sac::Stamp b) const { return a < b; }
  bool AnyAfter(sac::Stamp at) const {
    return std::ranges::any_of(records_, [at](const Record& r) { return at < r.stamp; });
  }
  void Request(sac::Kind kind, sac::Item item, sac::Epoch epoch) {
    requests.push_back({kind, item, epoch});
  }
  void Unrequest(sac::Kind kind, sac::Item item, sac::Epoch epoch) {
    std::erase(requests, Requested{kind, item, epoch});
  }

  sac::Kind kind(sac::OpId id) const { return records_[id].kind; }
  sac::Item item(sac::OpId id) const { return records_[id].item; }
  sac::Epoch epoch(sac::OpId id) const { return records_[id].epoch; }
  sac::Stamp stamp(sac::OpId id) const { return records_[id].stamp; }
  sac::OpId next_of_item(sac::OpId id) const { return records_[id].next_of_item; }
  bool executed(sac::OpId) const { return true; }
  const Payload& payload(sac::OpId id) const { return records_[id].payload; }
  std::span<const sac::Output> outputs(sac::OpId id) const { return records_[id].outputs; }
  std::span<const std::uint32_t> reads(sac::OpId id) const { return records_[id].reads; }

  template <class Affected>
  void Notify(sac::Place place, sac::Parts parts, sac::Stamp after, sac::Stamp until,
              Affected affected) {
    for (const auto& [id, of] : subscriptions_.at(place)) {
      if ((of & parts) == parts) NotifyOperation(id, after, until, affected);
    }
  }
  template <class Affected>
  void Notify(sac::Place place, sac::Stamp after, sac::Stamp until, Affected affected) {
    Notify(place, 0, after, until, affected);
  }
  template <class Affected>
  void NotifyAttentive(sac::Place place, sac::Stamp after, sac::Stamp until, Affected affected) {
    for (const auto& [id, of] : subscriptions_.attentive_at(place)) {
      NotifyOperation(id, after, until, affected);
    }
  }
  template <class Affected>
  void NotifyOperation(sac::OpId id, sac::Stamp after, sac::Stamp until, Affected affected) {
    Record& record = records_[id];
    if (record.stamp <= after || (until != sac::kNoStamp && until < record.stamp)) return;
    if (affected(id)) record.stale = true;
  }
  void NotifyChain(sac::OpId head, sac::Stamp after) {
    for (sac::OpId id = head; id != sac::kNoOp; id = next_of_item(id)) {
      if (after < stamp(id)) records_[id].stale = true;
    }
  }
  sac::Subscriptions& subscriptions() { return subscriptions_; }
  const sac::Subscriptions& subscriptions() const { return subscriptions_; }
  void ReplacePlace(sac::OpId id, sac::Place, sac::Place to) { subscriptions_.Add(to, id); }

 private:
  std::vector<Record> records_;
  sac::Subscriptions subscriptions_;
};

template <class Program>
class RecordingEngine<Program>::Context {
 public:
  Context(sac::Kind k, sac::Item i, sac::Epoch e, sac::Stamp at)
      : kind(k), item(i), epoch(e), now(at) {}

  const sac::Kind kind;
  const sac::Item item;
  const sac::Epoch epoch;
  const sac::Stamp now;

  // What is recorded.
  std::vector<sac::Output> outputs;
  std::vector<Requested> requests;
  std::vector<std::pair<sac::Place, sac::Parts>> subscriptions;
  std::vector<std::uint32_t> reads;
  Payload kept = {};
  // The former execution; if there are reads, it is not the first time.
  std::vector<sac::Output> former_outputs;
  std::vector<std::uint32_t> former_reads;

  bool Sees(sac::Stamp birth) const { return birth < now; }
  void Emit(sac::Output output) { outputs.push_back(output); }
  void Request(sac::Kind k, sac::Item i, sac::Epoch e) { requests.push_back({k, i, e}); }
  void Subscribe(sac::Place place, sac::Parts parts = sac::kAllParts) {
    subscriptions.emplace_back(place, parts);
  }
  void Read(std::uint32_t word) { reads.push_back(word); }
  std::span<const sac::Output> old_outputs() const { return former_outputs; }
  std::span<const std::uint32_t> old_reads() const { return former_reads; }
  Payload& payload() { return kept; }
  bool first_time() const { return former_reads.empty(); }
  sac::OpId id() const { return sac::kNoOp; }
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_RECORDING_ENGINE_H_
