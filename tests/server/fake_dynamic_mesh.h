// A DynamicMesh without geometry, so that server and client can be tested without a
// mesher: vertices are the points, subsegments the segments, and three points next to
// each other by id make a "triangle", which lies in the polygons that name all three. Its ids and
// hashes are the real ones. An edit is an operation.
#ifndef DYNMESH_TESTS_SERVER_FAKE_DYNAMIC_MESH_H_
#define DYNMESH_TESTS_SERVER_FAKE_DYNAMIC_MESH_H_

#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::server {

// Holds a fake's Apply between validation and change, after it has reported half of the latter, so
// that a test can order its steps.
// Thread-safe.
class FakeGate {
 public:
  void Hold();
  void HoldCancelled();  // even when it is cancelled, as a batch that takes long to undo
  void Release();
  // Waits until `count` calls of Apply have reached the gate since its making.
  void WaitForArrivals(int count);

  // Of the fake: false if a flag of the options turned true meanwhile.
  bool Pass(const ApplyOptions& options);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool held_ = false;
  bool heeds_cancellation_ = true;
  int arrivals_ = 0;
};

class FakeDynamicMesh final : public DynamicMesh {
 public:
  FakeDynamicMesh(const MeshOptions& options, std::shared_ptr<FakeGate> gate);

  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch,
                                 const ApplyOptions& apply_options) override;
  void TakeBack(std::size_t revisions) override;
  void SettleAllBut(std::size_t revisions) override {
    revocable_.erase(revocable_.begin(), revocable_.end() - static_cast<std::ptrdiff_t>(revisions));
  }
  void ResumeAt(std::uint64_t revision) override {
    Settle();
    mesh_.revision = revision;
  }
  absl::Status Validate(const EditBatch& batch) const override;
  Mesh Snapshot() const override { return mesh_; }
  // All points in the box are in the first triangle, if there is one.
  SimplexColumn Locate(std::span<const double> points) const override;
  std::vector<double> LeafSides(std::span<const double> /*points*/) const override { return {}; }
  std::vector<Feature> Features() const override;
  const MeshOptions& options() const override { return options_; }
  std::uint64_t revision() const override { return mesh_.revision; }
  MeshHash hash() const override { return mesh_.hash; }
  MeshStats Stats() const override;
  AuditReport Audit() const override { return {}; }

 private:
  using FeatureMap = std::map<FeatureId, Feature>;
  absl::StatusOr<FeatureMap> Draft(const EditBatch& batch) const;
  Mesh Build(const FeatureMap& features) const;

  const MeshOptions options_;
  const std::shared_ptr<FakeGate> gate_;
  FeatureMap features_;
  Mesh mesh_;
  std::vector<std::pair<FeatureMap, Mesh>> revocable_;  // what was before each such batch
};

// A MeshFactory; without a gate nothing is ever held.
absl::StatusOr<std::unique_ptr<DynamicMesh>> MakeFake(const MeshOptions& options,
                                                      std::shared_ptr<FakeGate> gate = nullptr);

// A MeshBuilder: that fake's mesh of the features.
absl::StatusOr<Mesh> BuildFake(std::span<const Feature> features, const MeshOptions& options,
                               const BuildOptions& build, std::shared_ptr<FakeGate> gate = nullptr);

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_FAKE_DYNAMIC_MESH_H_
