#include "tests/e2e/soak/writer.h"

#include <chrono>
#include <cmath>
#include <thread>

#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::soak {
namespace {

constexpr std::size_t kOwnPoints = 200;
constexpr std::size_t kSlots = 8;  // of segments and discs, each with a cell of its own
constexpr FeatureId kSlotIds = 1'000;
constexpr FeatureId kIdsOfWriter = 1'000'000'000'000;

std::string ReasonOf(const absl::Status& status) {
  const auto error = codec::GetServiceError(status);
  return error.has_value() ? error->reason : "";
}

}  // namespace

double MeshPlan::Spacing() const {
  return std::pow(static_cast<double>(vertices), -1.0 / dimension);
}

absl::Status LoadMesh(const MeshPlan& plan, client::MeshClient& client, std::uint64_t seed,
                      Ledger& ledger) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  FeatureId next = 1;
  while (true) {
    const auto status = client.GetStats(plan.name);
    if (!status.ok()) return status.status();
    const std::uint64_t vertices = status->mesh->stats.vertices;
    if (vertices >= plan.vertices) return absl::OkStatus();
    // A point brings less than 1.7 vertices: the rest comes ever closer.
    EditBatch batch;
    for (std::uint64_t n = 1 + (plan.vertices - vertices) / 2; n > 0; --n) {
      const double x = unit(random), y = unit(random), z = unit(random);
      batch.push_back(Edit::Add(Feature::Point(next++, x, y, z)));
    }
    client::EditParams params;
    params.omit_columns = true;
    params.dimension = plan.dimension;
    const auto result = client.Apply(plan.name, batch, params);
    if (!result.ok()) return result.status();
    ledger.Answered(*result);
  }
}

Writer::Writer(const Config& config, client::MeshClient* client, Ledger* ledger, Faults* faults)
    : config_(config),
      client_(client),
      ledger_(ledger),
      faults_(faults),
      random_(config.seed),
      own_{{},
           std::vector<bool>(kSlots),
           kFirstOwnId + kIdsOfWriter * static_cast<FeatureId>(config.index) + kSlotIds} {}

void Writer::Run(const absl::Notification& stop) {
  EditBatch first;
  while (own_.points.size() < kOwnPoints) {
    own_.points.push_back({own_.next_id++, Anywhere()});
    first.push_back(AddPoint(own_.points.back().id, own_.points.back().place));
  }
  Apply(first, Params(), &ledger_->batch);
  std::exponential_distribution<double> gap(config_.rate);
  auto next = std::chrono::steady_clock::now();
  while (true) {
    next += std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::duration<double>(gap(random_)));
    // Missed edits are not made up for: the rate is that of a steady client.
    next = std::max(next, std::chrono::steady_clock::now() - std::chrono::seconds(1));
    const auto pause = next - std::chrono::steady_clock::now();
    if (stop.WaitForNotificationWithTimeout(absl::FromChrono(pause))) return;
    Step();
  }
}

void Writer::Step() {
  const std::size_t dice = Below(100);
  if (dice < 3) return Refused();
  if (dice < 6) return Cancelled();
  if (dice < 15) return Batch();
  SingleEdit();
}

void Writer::SingleEdit() {
  Own own = own_;
  const Edit edit = PointEdit(own);
  if (Apply({edit}, Params(), &ledger_->single)) own_ = std::move(own);
}

void Writer::Batch() {
  Own own = own_;
  const EditBatch batch = RandomBatch(own);
  if (Apply(batch, Params(Below(2) == 0), &ledger_->batch)) own_ = std::move(own);
}

void Writer::Refused() {
  const auto point = own_.points[Below(own_.points.size())];
  const FeatureId fresh = own_.next_id++;
  client::EditParams params = Params();
  // A good edit goes first: it must not stay.
  EditBatch batch = {AddPoint(own_.next_id++, Anywhere())};
  std::string reason;
  switch (Below(config_.plan.beyond_limit ? 8 : 7)) {
    case 0:
      reason = reason::kUnknownFeature;
      batch.push_back(Edit::Remove(fresh));
      break;
    case 1:
      reason = reason::kIdInUse;
      batch.push_back(AddPoint(point.id, Anywhere()));
      break;
    case 2:
      reason = reason::kDuplicatePoint;
      batch.push_back(AddPoint(fresh, point.place));
      break;
    case 3:
      reason = reason::kOutsideBox;
      batch.push_back(AddPoint(fresh, {0.5, 1.5, 0.5}));
      break;
    case 4:
      reason = codec::reason::kRevisionMismatch;
      params.expected_revision = 0;
      break;
    case 5:
      reason = reason::kUnknownEnd;
      batch.push_back(Edit::Add(Feature::Segment(fresh, point.id, fresh + 1'000)));
      break;
    case 6:
      reason = codec::reason::kWrongDimension;
      params.dimension = 5 - params.dimension;
      break;
    default: {
      reason = reason::kVertexLimit;
      const Sizing all = {SizeShape::kDisc, config_.plan.Spacing() / 10, 1, {}};
      batch.push_back(Edit::Add(Feature::Size(fresh, {0.5, 0.5, 0.5}, all)));
    }
  }
  const auto result = client_->Apply(config_.plan.name, batch, params);
  if (result.ok() || ReasonOf(result.status()) != reason) {
    return Fault(absl::StrCat("not refused with ", reason), result.status());
  }
  ++ledger_->refused;
}

// A cancelled batch was applied or not; its retry finds out, and applies it if it was not.
void Writer::Cancelled() {
  Own own = own_;
  const EditBatch batch = RandomBatch(own);
  const client::EditParams params = Params(true);
  {
    const auto session = client_->OpenEdits(config_.plan.name);
    if (const absl::Status sent = session->Send(batch, params); !sent.ok()) {
      return Fault("an edit stream", sent);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(Below(4'000)));
    session->Cancel();
  }
  ++ledger_->cancelled;
  if (Apply(batch, params, nullptr)) own_ = std::move(own);
}

Edit Writer::PointEdit(Own& own) {
  const std::size_t dice = Below(4);
  // Adds and removes keep the number near its target.
  const bool few = own.points.size() < kOwnPoints / 2 + Below(kOwnPoints);
  if (dice == 0 && few) {
    own.points.push_back({own.next_id++, Anywhere()});
    return AddPoint(own.points.back().id, own.points.back().place);
  }
  Own::Point& point = own.points[Below(own.points.size())];
  if (dice == 0) {
    const FeatureId id = point.id;
    point = own.points.back();
    own.points.pop_back();
    return Edit::Remove(id);
  }
  point.place = dice == 1 ? Anywhere() : Near(point.place, config_.plan.Spacing());
  return Edit::Move(point.id, point.place[0], point.place[1], point.place[2]);
}

EditBatch Writer::RandomBatch(Own& own) {
  if (Below(3) == 0) return Toggle(own, Below(kSlots));
  EditBatch batch;
  for (std::size_t n = 2 + Below(15); n > 0; --n) batch.push_back(PointEdit(own));
  return batch;
}

// Adds or removes a segment with its ends, in every third slot a disc.
EditBatch Writer::Toggle(Own& own, std::size_t slot) {
  const FeatureId first = kFirstOwnId + kIdsOfWriter * static_cast<FeatureId>(config_.index) +
                          4 * static_cast<FeatureId>(slot);
  const bool there = own.slots[slot];
  own.slots[slot] = !there;
  const double spacing = config_.plan.Spacing();
  if (slot % 3 == 0) {
    if (there) return {Edit::Remove(first)};
    // Adds or removes some dozens of vertices.
    const bool plane = config_.plan.dimension == 2;
    const Sizing disc = {SizeShape::kDisc, spacing / 2, (plane ? 2 : 0.7) * spacing, {}};
    return {Edit::Add(Feature::Size(first, InCell(slot), disc))};
  }
  if (there) return {Edit::Remove(first + 2), Edit::Remove(first), Edit::Remove(first + 1)};
  return {AddPoint(first, InCell(slot)), AddPoint(first + 1, InCell(slot)),
          Edit::Add(Feature::Segment(first + 2, first, first + 1))};
}

bool Writer::Apply(const EditBatch& batch, const client::EditParams& params, Latencies* times) {
  const auto start = std::chrono::steady_clock::now();
  const auto result = client_->Apply(config_.plan.name, batch, params);
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
  if (!result.ok()) {
    Fault("a good batch", result.status());
    return false;
  }
  if (times != nullptr) times->Add(took.count());
  ledger_->replayed += result->replayed ? 1 : 0;
  ledger_->Answered(*result);
  return true;
}

void Writer::Fault(const std::string& what, const absl::Status& status) {
  faults_->Add(absl::StrCat("writer ", config_.index, " of ", config_.plan.name, ": ", what, ": ",
                            status.ToString()));
  // The waiting thread detects a server that has ended; here it must not fill the log.
  if (absl::IsUnavailable(status)) std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

Writer::Place Writer::Anywhere() { return {Unit(), Unit(), Unit()}; }

Writer::Place Writer::Near(const Place& place, double reach) {
  std::uniform_real_distribution<double> shift(-reach, reach);
  Place near = place;
  for (double& x : near) {
    const double moved = x + shift(random_);
    if (moved > 0 && moved < 1) x = moved;
  }
  return near;
}

// Cells of different slots and writers have nothing in common, so their segments do not cross.
Writer::Place Writer::InCell(std::size_t slot) {
  const std::size_t cells = kSlots * static_cast<std::size_t>(config_.writers);
  const auto cell = static_cast<double>(slot + kSlots * static_cast<std::size_t>(config_.index));
  Place place = Anywhere();
  place[0] = (cell + place[0]) / static_cast<double>(cells);
  // Of a few vertices' length.
  const double reach = std::min(0.4, 4 * config_.plan.Spacing());
  place[1] = 0.5 + (place[1] - 0.5) * reach;
  place[2] = 0.5 + (place[2] - 0.5) * reach;
  return place;
}

Edit Writer::AddPoint(FeatureId id, const Place& p) const {
  return Edit::Add(Feature::Point(id, p[0], p[1], p[2]));
}

client::EditParams Writer::Params(bool named) {
  client::EditParams params;
  params.dimension = config_.plan.dimension;
  if (named) params.request_id = absl::StrCat("w", config_.index, "-", requests_++);
  return params;
}

}  // namespace dynmesh::soak
