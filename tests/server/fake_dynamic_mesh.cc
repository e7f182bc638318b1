#include "tests/server/fake_dynamic_mesh.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/mesh_data/canonical_order.h"
#include "core/mesh_data/diff_meshes.h"
#include "dynmesh/error.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

absl::Status EditError(absl::StatusCode code, const char* reason_text, std::size_t edit,
                       FeatureId id) {
  return MakeError(code, absl::StrCat("feature ", id, ": ", reason_text),
                   {reason_text, {id}, edit});
}

// The polygons that name all of these points.
std::vector<FeatureId> PolygonsAround(const std::vector<const Feature*>& all,
                                      std::span<const FeatureId> points) {
  std::vector<FeatureId> polygons;
  for (const Feature* f : all) {
    const auto names = [&](FeatureId point) {
      return std::ranges::any_of(f->rings,
                                 [&](const auto& ring) { return std::ranges::count(ring, point); });
    };
    if (std::ranges::all_of(points, names)) polygons.push_back(f->id);
  }
  return polygons;
}

}  // namespace

void FakeGate::Hold() {
  const std::lock_guard lock(mutex_);
  held_ = true;
}

void FakeGate::HoldCancelled() {
  const std::lock_guard lock(mutex_);
  heeds_cancellation_ = false;
}

void FakeGate::Release() {
  const std::lock_guard lock(mutex_);
  held_ = false;
  heeds_cancellation_ = true;
  changed_.notify_all();
}

void FakeGate::WaitForArrivals(int count) {
  std::unique_lock lock(mutex_);
  test::WaitUntil("arrivals at the gate", changed_, lock, [&] { return arrivals_ >= count; });
}

bool FakeGate::Pass(const ApplyOptions& options) {
  const auto is_cancelled = [&options] {
    return options.interrupted != nullptr && options.interrupted();
  };
  std::unique_lock lock(mutex_);
  ++arrivals_;
  changed_.notify_all();
  // Polled, as the real one does between operations.
  while (held_ && !(heeds_cancellation_ && is_cancelled()))
    changed_.wait_for(lock, std::chrono::milliseconds(1));
  return !is_cancelled();
}

FakeDynamicMesh::FakeDynamicMesh(const MeshOptions& options, std::shared_ptr<FakeGate> gate)
    : options_(options), gate_(std::move(gate)), mesh_(Build({})) {}

absl::StatusOr<FakeDynamicMesh::FeatureMap> FakeDynamicMesh::Draft(const EditBatch& batch) const {
  FeatureMap draft = features_;
  for (std::size_t i = 0; i < batch.size(); ++i) {
    const Feature& f = batch[i].feature;
    const bool present = draft.contains(f.id);
    const bool add = batch[i].action == Edit::Action::kAdd;
    if (f.id == kNoFeature || f.id == kBoxFeature) {
      return EditError(absl::StatusCode::kInvalidArgument, reason::kBadId, i, f.id);
    }
    if (add && present) {
      return EditError(absl::StatusCode::kAlreadyExists, reason::kIdInUse, i, f.id);
    }
    if (!add && !present) {
      return EditError(absl::StatusCode::kNotFound, reason::kUnknownFeature, i, f.id);
    }
    if (batch[i].action == Edit::Action::kRemove) {
      draft.erase(f.id);
      continue;
    }
    if (batch[i].action == Edit::Action::kSetLabel) {
      draft[f.id].label = f.label;
      continue;
    }
    for (int k = 0; k < 2 && f.kind == FeatureKind::kPoint; ++k) {
      if (!std::isfinite(f.position[k])) {
        return EditError(absl::StatusCode::kInvalidArgument, reason::kNotFinite, i, f.id);
      }
      if (f.position[k] < options_.box.lo[k] || f.position[k] > options_.box.hi[k]) {
        return EditError(absl::StatusCode::kInvalidArgument, reason::kOutsideBox, i, f.id);
      }
    }
    const OptionalLabel label = draft[f.id].label;
    draft[f.id] = f;
    if (!f.label) draft[f.id].label = label;
  }
  std::set<std::array<double, 3>> places;
  for (const auto& [id, f] : draft) {
    if (f.kind == FeatureKind::kPoint && !places.insert(f.position).second) {
      return MakeError(absl::StatusCode::kFailedPrecondition, "two points in one place",
                       {reason::kDuplicatePoint, {id}, std::nullopt});
    }
    for (const auto& ring : f.rings) {
      for (const FeatureId point : ring) {
        if (draft.contains(point)) continue;
        return MakeError(absl::StatusCode::kNotFound,
                         absl::StrCat("polygon ", id, " needs ", point),
                         {reason::kUnknownEnd, {id, point}, std::nullopt});
      }
    }
    for (const FeatureId end : f.ends) {
      if (f.kind == FeatureKind::kSegment && !draft.contains(end)) {
        return MakeError(absl::StatusCode::kNotFound, absl::StrCat("segment ", id, " needs ", end),
                         {reason::kUnknownEnd, {id, end}, std::nullopt});
      }
    }
  }
  if (places.size() > options_.limits.max_vertices) {
    return MakeError(absl::StatusCode::kResourceExhausted, "too many vertices",
                     {reason::kVertexLimit, {}, std::nullopt});
  }
  return draft;
}

Mesh FakeDynamicMesh::Build(const FeatureMap& features) const {
  Mesh mesh;
  std::vector<FeatureId> points;
  std::vector<const Feature*> all_polygons;
  for (const auto& [id, f] : features) {
    if (f.kind == FeatureKind::kPolygon) {
      all_polygons.push_back(&f);
    } else if (f.kind == FeatureKind::kPoint) {
      points.push_back(id);
      mesh.vertices.ids.push_back(VertexIdAt(f.position.data(), 2));
      mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(),
                                       {f.position[0], f.position[1]});
      mesh.vertices.containing_dimensions.push_back(0);
      mesh.vertices.owners.push_back(id);
    } else {
      VertexId a = VertexIdAt(features.at(f.ends[0]).position.data(), 2);
      VertexId b = VertexIdAt(features.at(f.ends[1]).position.data(), 2);
      mesh.subsegments.ends.insert(mesh.subsegments.ends.end(), {std::min(a, b), std::max(a, b)});
      mesh.subsegments.owners.push_back(id);
    }
  }
  const std::vector<VertexId>& v = mesh.vertices.ids;
  for (std::size_t i = 0; i + 2 < v.size(); ++i) {
    const auto corners =
        mesh_data::InCanonicalOrder(std::array<VertexId, 3>{v[i], v[i + 1], v[i + 2]});
    mesh.simplices.insert(mesh.simplices.end(), corners.begin(), corners.end());
    const std::vector<FeatureId> polygons = PolygonsAround(all_polygons, {&points[i], 3});
    mesh.regions.push_back(RegionIdOf(polygons));
    if (polygons.size() > 1) mesh.region_sets.push_back({mesh.regions.back(), polygons});
  }
  std::ranges::sort(mesh.region_sets, {}, &RegionSet::id);
  const auto same_id = [](const RegionSet& a, const RegionSet& b) { return a.id == b.id; };
  mesh.region_sets.erase(std::unique(mesh.region_sets.begin(), mesh.region_sets.end(), same_id),
                         mesh.region_sets.end());
  mesh.hash = ComputeHash(mesh);
  for (const auto& [id, f] : features) {
    if (f.label) mesh.labels.push_back({id, *f.label});
  }
  return mesh;
}

absl::StatusOr<MeshDiff> FakeDynamicMesh::Apply(const EditBatch& batch,
                                                const ApplyOptions& apply_options) {
  using Stage = ApplyProgress::Stage;
  const std::uint64_t all = 2 * batch.size();
  const auto tell = [&](Stage stage, std::uint64_t done) {
    if (apply_options.progress != nullptr) apply_options.progress({stage, done, all});
  };
  tell(Stage::kValidate, 0);
  absl::StatusOr<FeatureMap> draft = Draft(batch);
  if (!draft.ok()) return draft.status();
  tell(Stage::kValidate, all);
  if (apply_options.max_operations != 0 && batch.size() > apply_options.max_operations) {
    return MakeError(absl::StatusCode::kResourceExhausted, "too much work",
                     {reason::kWorkLimit, {}, std::nullopt});
  }
  tell(Stage::kRefine, all / 2);
  if (gate_ != nullptr && !gate_->Pass(apply_options)) {
    return MakeError(absl::StatusCode::kCancelled, "cancelled",
                     {reason::kCancelled, {}, std::nullopt});
  }
  tell(Stage::kRefine, all);
  Mesh next = Build(*draft);
  tell(Stage::kDiff, all);
  next.revision = batch.empty() ? mesh_.revision : mesh_.revision + 1;
  MeshDiff diff = mesh_data::DiffMeshes(mesh_, next);
  diff.work.executed = batch.size();
  if (apply_options.commit != nullptr) {
    if (absl::Status status = apply_options.commit(diff); !status.ok()) return status;
  }
  if (!apply_options.revocable) {
    Settle();
  } else if (!batch.empty()) {
    revocable_.emplace_back(features_, mesh_);
  }
  features_ = *std::move(draft);
  mesh_ = std::move(next);
  return diff;
}

void FakeDynamicMesh::TakeBack(std::size_t revisions) {
  for (; revisions > 0; --revisions) {
    std::tie(features_, mesh_) = std::move(revocable_.back());
    revocable_.pop_back();
  }
}

absl::Status FakeDynamicMesh::Validate(const EditBatch& batch) const {
  return Draft(batch).status();
}

SimplexColumn FakeDynamicMesh::Locate(std::span<const double> points) const {
  SimplexColumn found;
  for (std::size_t i = 0; i + 1 < points.size(); i += 2) {
    const bool inside = points[i] >= options_.box.lo[0] && points[i] <= options_.box.hi[0] &&
                        points[i + 1] >= options_.box.lo[1] &&
                        points[i + 1] <= options_.box.hi[1] && !mesh_.simplices.empty();
    for (std::size_t k = 0; k < 3; ++k) found.push_back(inside ? mesh_.simplices[k] : 0);
  }
  return found;
}

std::vector<Feature> FakeDynamicMesh::Features() const {
  std::vector<Feature> all;
  for (const auto& [id, f] : features_) all.push_back(f);
  return all;
}

MeshStats FakeDynamicMesh::Stats() const {
  MeshStats stats;
  stats.revision = mesh_.revision;
  stats.features = features_.size();
  stats.vertices = mesh_.vertices.size();
  stats.simplices = mesh_.simplex_count();
  stats.subsegments = mesh_.subsegments.size();
  return stats;
}

absl::StatusOr<std::unique_ptr<DynamicMesh>> MakeFake(const MeshOptions& options,
                                                      std::shared_ptr<FakeGate> gate) {
  return std::make_unique<FakeDynamicMesh>(options, std::move(gate));
}

absl::StatusOr<Mesh> BuildFake(std::span<const Feature> features, const MeshOptions& options,
                               const BuildOptions& build, std::shared_ptr<FakeGate> gate) {
  FakeDynamicMesh mesh(options, std::move(gate));
  ApplyOptions apply;
  apply.interrupted = build.interrupted;
  apply.max_operations = build.max_operations;
  apply.progress = build.progress;
  if (const auto applied = mesh.Apply(AddAll(features), apply); !applied.ok()) {
    return applied.status();
  }
  return mesh.Snapshot();
}

}  // namespace dynmesh::server
