// A DynamicMesh that hands all calls on, for tests that override some.
#ifndef DYNMESH_TESTS_SERVER_MESHES_MESH_DECORATOR_H_
#define DYNMESH_TESTS_SERVER_MESHES_MESH_DECORATOR_H_

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::server {

class MeshDecorator : public DynamicMesh {
 public:
  explicit MeshDecorator(std::unique_ptr<DynamicMesh> mesh) : mesh_(std::move(mesh)) {}

  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch, const ApplyOptions& options) override {
    return mesh_->Apply(batch, options);
  }
  void TakeBack(std::size_t revisions) override { mesh_->TakeBack(revisions); }
  void SettleAllBut(std::size_t revisions) override { mesh_->SettleAllBut(revisions); }
  void ResumeAt(std::uint64_t revision) override { mesh_->ResumeAt(revision); }
  absl::Status Validate(const EditBatch& batch) const override { return mesh_->Validate(batch); }
  Mesh Snapshot() const override { return mesh_->Snapshot(); }
  SimplexColumn Locate(std::span<const double> points) const override {
    return mesh_->Locate(points);
  }
  std::vector<double> LeafSides(std::span<const double> points) const override {
    return mesh_->LeafSides(points);
  }
  std::vector<Feature> Features() const override { return mesh_->Features(); }
  const MeshOptions& options() const override { return mesh_->options(); }
  std::uint64_t revision() const override { return mesh_->revision(); }
  MeshHash hash() const override { return mesh_->hash(); }
  MeshStats Stats() const override { return mesh_->Stats(); }
  AuditReport Audit() const override { return mesh_->Audit(); }

 protected:
  const std::unique_ptr<DynamicMesh> mesh_;
};

// Records the mesh's trace before each batch, since the mesh in a host cannot be queried.
class WatchedMesh final : public MeshDecorator {
 public:
  WatchedMesh(std::unique_ptr<DynamicMesh> mesh, std::vector<MeshHash>* traces)
      : MeshDecorator(std::move(mesh)), traces_(traces) {}
  absl::StatusOr<MeshDiff> Apply(const EditBatch& batch, const ApplyOptions& options) override {
    traces_->push_back(mesh_->Audit().trace);
    return mesh_->Apply(batch, options);
  }

 private:
  std::vector<MeshHash>* const traces_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_MESHES_MESH_DECORATOR_H_
