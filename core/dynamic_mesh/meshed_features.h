// A set of features and what is computed from it: the trace, the mesh, and the tables between them.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_MESHED_FEATURES_H_
#define DYNMESH_CORE_DYNAMIC_MESH_MESHED_FEATURES_H_

#include <cstddef>
#include <memory>

#include "core/dynamic_mesh/diff_builder.h"
#include "core/dynamic_mesh/feature_table.h"
#include "core/dynamic_mesh/live_features.h"
#include "core/dynamic_mesh/live_mesh_tuning.h"
#include "core/meshing/refinement.h"
#include "core/plc/plc.h"
#include "dynmesh/options.h"

namespace dynmesh {

// Everything computed from the features. New: of none, and nothing is computed yet.
template <int D>
struct MeshState {
  using Refinement = meshing::Refinement<D, sac::Engine>;

  MeshState(const MeshOptions& options, const LiveMeshTuning& tuning)
      : diffs(options.kind, tuning.vertex_hash),
        refinement(options, tuning.global_neighbourhoods ? &diffs.triangulation() : nullptr) {
    if (!tuning.global_neighbourhoods) refinement.complex().ResetToDomain(&diffs.triangulation());
    refinement.engine().set_limits(tuning.engine_limits);
    if constexpr (D == 3) {
      if (tuning.most_tetrahedra > 0) {
        diffs.triangulation().set_most_simplices(tuning.most_tetrahedra);
      }
    }
  }

  DiffBuilder<D> diffs;
  FeatureTable<D> features;
  Refinement refinement;
};

// Thread-compatible.
template <int D>
struct MeshedFeatures {
  MeshedFeatures(const MeshOptions& of, const LiveMeshTuning& with)
      : options(of), tuning(with), plc(of), state(std::make_unique<MeshState<D>>(of, with)) {}

  // Meshes the bare box. False if it was interrupted: the state is then no mesh.
  bool Begin(Interrupt interrupt);
  // Takes back an applied change, which the trace may have followed in part. The inverse edit
  // restores the former trace, bit for bit. If that is too expensive, builds from scratch. `plc`
  // must hold the former features.
  void Undo(const plc::Delta<D>& delta);
  // Discards the state and builds that of the present features.
  void BuildPresent();
  // The same, beside the present state. Keeps it if interrupted.
  void ReplaceState(Interrupt interrupt);

  const MeshOptions options;
  const LiveMeshTuning tuning;
  plc::Plc<D> plc;
  std::unique_ptr<MeshState<D>> state;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_MESHED_FEATURES_H_
