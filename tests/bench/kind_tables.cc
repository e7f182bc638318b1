// A Delaunay mesh and a quadtree of the same features, side by side: what building costs, and
// edits, beside their bound. CSV on standard output.
//
//   dynmesh_kind_tables [MOST]    scenes of 1,000, 10,000, ... up to MOST (default: 100,000)
//                                 features, in 3D a tenth of that; of combs and polygons up to
//                                 10,000
//
// build: from scratch, without a trace, validation included. load: the same as one batch. edit: a
// feature without users is removed, and added again; the median of both. operations: run again, or
// dropped, an edit. changed: vertices that came and went (of a quadtree leaves). Times are of this
// thread's processor. bytes: of the trace and of all, for each vertex.
//
// carried: m_f, the vertices (leaves) that the feature carries, the mean of those edited. spread:
// lg(L/s). operations_bound, changed_bound: the mean over edits of operations (changed) over
// m_f lg(L/s), and worst_bound the greatest for operations.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "client/cli/percentile.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/bench/carried.h"
#include "tests/bench/edit_scenes.h"
#include "tests/bench/thread_clock.h"
#include "tests/support/workload.h"

namespace dynmesh {
namespace {

constexpr int kEdits = 200;

MeshOptions OptionsOf(int dimension, MeshKind kind) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.kind = kind;
  return options;
}

struct Figures {
  std::size_t vertices = 0;
  double build_ms = 0, load_ms = 0, edit_us = 0, operations = 0, changed = 0;
  double trace_bytes = 0, bytes = 0;
  double carried = 0, spread = 0, operations_bound = 0, changed_bound = 0, worst_bound = 0;
};

template <class Carried>
void MeasureEdits(const EditScene& scene, const Carried& carried, DynamicMesh& mesh,
                  Figures* figures) {
  test::Random random(7);
  std::vector<double> times;
  figures->spread = carried.lg_spread();
  for (int i = 0; i < kEdits; ++i) {
    const Feature& f = scene.features[scene.edited[static_cast<std::size_t>(
        random.Below(static_cast<int>(scene.edited.size())))]];
    double operations = 0, changed = 0;
    for (const EditBatch& batch : {EditBatch{Edit::Remove(f.id)}, EditBatch{Edit::Add(f)}}) {
      const double start = ThreadSeconds();
      const auto diff = mesh.Apply(batch);
      times.push_back(1e6 * (ThreadSeconds() - start));
      if (!diff.ok()) {
        std::fprintf(stderr, "%s: %s\n", scene.name.c_str(), diff.status().ToString().c_str());
        std::exit(1);
      }
      operations += static_cast<double>(diff->work.executed + diff->work.dropped) / 2;
      changed +=
          static_cast<double>(diff->added_vertices.size() + diff->removed_vertices.size()) / 2;
    }
    const double count = std::max(carried.Count(f), 1.0), bound = count * carried.lg_spread();
    figures->carried += count / kEdits;
    figures->operations += operations / kEdits;
    figures->changed += changed / kEdits;
    figures->operations_bound += operations / bound / kEdits;
    figures->changed_bound += changed / bound / kEdits;
    figures->worst_bound = std::max(figures->worst_bound, operations / bound);
  }
  figures->edit_us = cli::Percentile(times, 0.5);
}

Figures Measure(const EditScene& scene, MeshKind kind) {
  const MeshOptions options = OptionsOf(scene.dimension, kind);
  Figures figures;
  double start = ThreadSeconds();
  const auto built = BuildMesh(scene.features, options);
  figures.build_ms = 1e3 * (ThreadSeconds() - start);
  if (!built.ok()) {
    std::fprintf(stderr, "%s: %s\n", scene.name.c_str(), built.status().ToString().c_str());
    std::exit(1);
  }
  figures.vertices = built->vertices.size();
  const auto mesh = *DynamicMesh::Create(options);
  const EditBatch all = AddAll(scene.features);
  start = ThreadSeconds();
  if (!mesh->Apply(all).ok()) std::exit(1);
  figures.load_ms = 1e3 * (ThreadSeconds() - start);
  const MeshStats stats = mesh->Stats();
  figures.trace_bytes =
      static_cast<double>(stats.trace_bytes) / static_cast<double>(built->vertices.size());
  figures.bytes = static_cast<double>(stats.trace_bytes + stats.mesh_bytes) /
                  static_cast<double>(built->vertices.size());
  if (kind == MeshKind::kQuadtree) {
    MeasureEdits(scene, CarriedLeaves(*built, options, scene.features), *mesh, &figures);
  } else {
    MeasureEdits(scene, CarriedVertices(*built, options), *mesh, &figures);
  }
  return figures;
}

int Run(int most) {
  std::printf(
      "scene,features,kind,vertices,build_ms,load_ms,edit_us,operations,changed,trace_bytes,bytes,"
      "carried,spread,operations_bound,changed_bound,worst_bound\n");
  for (const std::string& name : EditSceneNames()) {
    for (int n = 1000; n <= std::min(most, MostFeatures(name)); n *= 10) {
      const EditScene scene = MakeEditScene(name, n);
      if (scene.dimension == 3 && n > most / 10) break;
      for (const MeshKind kind : {MeshKind::kQuadtree, MeshKind::kDelaunay}) {
        const Figures f = Measure(scene, kind);
        std::printf(
            "\"%s\",%zu,%s,%zu,%.1f,%.1f,%.1f,%.1f,%.1f,%.0f,%.0f,%.1f,%.1f,%.3f,%.3f,%.3f\n",
            name.c_str(), scene.features.size(),
            kind == MeshKind::kQuadtree ? "quadtree" : "delaunay", f.vertices, f.build_ms,
            f.load_ms, f.edit_us, f.operations, f.changed, f.trace_bytes, f.bytes, f.carried,
            f.spread, f.operations_bound, f.changed_bound, f.worst_bound);
        std::fflush(stdout);
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  const int most = argc > 1 ? std::atoi(argv[1]) : 100'000;
  if (most < 1000) {
    std::fputs("usage: dynmesh_kind_tables [MOST], at least 1000 features\n", stderr);
    return 2;
  }
  return dynmesh::Run(most);
}
