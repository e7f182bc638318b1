// A size-conforming quadtree or octree as DynamicMesh. An edit passes through: Plc validates the
// batch (live_features.h); ShapeTable applies the change to BuildQt, which propagates it; LeafIds
// names the leaves that came and went.
//
// An edit is always propagated: a propagation costs hardly more than a run from scratch, even if
// all features change.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_LIVE_QUADTREE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_LIVE_QUADTREE_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "core/dynamic_mesh/leaf_ids.h"
#include "core/dynamic_mesh/live_features.h"
#include "core/dynamic_mesh/shape_table.h"
#include "core/plc/plc.h"
#include "core/quadtree/build_qt.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh {

template <int D>
class LiveQuadtree final : public LiveFeatures<D> {
 public:
  // REQUIRES: ValidateOptions(options) is OK, the dimension is D. `id_of`: tests use a poor hash.
  explicit LiveQuadtree(const MeshOptions& options, VertexHash id_of = &VertexIdAt);

  Mesh Snapshot() const override;
  SimplexColumn Locate(std::span<const double> points) const override;
  std::vector<double> LeafSides(std::span<const double> points) const override;
  const MeshOptions& options() const override { return options_; }
  MeshHash hash() const override { return leaves_.hash(); }
  MeshStats Stats() const override;
  AuditReport Audit() const override;

 protected:
  plc::Plc<D>& plc() override { return plc_; }
  const plc::Plc<D>& plc() const override { return plc_; }
  absl::StatusOr<MeshDiff> Run(const plc::Delta<D>& delta,
                               const typename LiveFeatures<D>::Batch& batch,
                               Commit commit) override;
  void Undo(const plc::Delta<D>& delta) override;
  void GiveMemoryBack(Interrupt interrupt) override;

 private:
  using Tree = quadtree::BuildQt<D, sac::Engine>;
  struct State {
    explicit State(const quadtree::Grid<D>& grid) : tree(grid) {}
    ShapeTable<D> shapes;
    Tree tree;
  };

  absl::Status Propagate(const typename LiveFeatures<D>::Batch& batch);
  // The leaves that came and went since the last call. Rows are in no order.
  MeshDiff TakeChanges();
  absl::Status StatusOfIds() const;
  // Calls f(leaf or nothing) for each point.
  template <class F>
  void ForEachLeafAt(std::span<const double> points, F f) const;

  const MeshOptions options_;
  plc::Plc<D> plc_;
  const quadtree::Grid<D> grid_;
  std::unique_ptr<State> state_;
  LeafIds<D> leaves_;
};

// BuildMesh (dynamic_mesh.h): the same from scratch, without a trace.
template <int D>
absl::StatusOr<Mesh> BuildQuadtree(std::span<const Feature> features, const MeshOptions& options,
                                   const BuildOptions& build);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_LIVE_QUADTREE_H_
