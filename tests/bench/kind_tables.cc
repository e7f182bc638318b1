// A Delaunay mesh and a quadtree of the same features, side by side, as tables on standard output.
//
//   dynmesh_kind_tables [MOST]    scenes of 1,000, 10,000, ... up to MOST (default: 100,000) points
//
// build: from scratch, without a trace, validation included. load: the same as one batch. edit: a
// feature without users is removed, and added again; the median of both. operations: run again, or
// dropped, an edit. changed: vertices that came and went (of a quadtree leaves). Times are of this
// thread's processor.
//
// The last column is the mean of operations / (m_f lg(L/s)) of the quadtree: m_f is the number of
// leaves that the feature meets, lg(L/s) the level of the finest leaf.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "client/cli/percentile.h"
#include "core/quadtree/shape.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/quadtree.h"
#include "tests/bench/thread_clock.h"
#include "tests/support/workload.h"

namespace dynmesh {
namespace {

using test::Distribution;

constexpr int kEdits = 200;

MeshOptions OptionsOf(int dimension, MeshKind kind) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.kind = kind;
  return options;
}

// Rows of features that no other feature needs.
std::vector<std::size_t> FreeRows(const std::vector<Feature>& features) {
  absl::flat_hash_set<FeatureId> used;
  for (const Feature& f : features) {
    for (const FeatureId id : test::PointsOf(f)) used.insert(id);
  }
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!used.contains(features[i].id)) rows.push_back(i);
  }
  return rows;
}

// Counts the leaves that features meet.
class LeafCounter {
 public:
  LeafCounter(const Mesh& mesh, const MeshOptions& options, const std::vector<Feature>& features)
      : dimension_(options.dimension) {
    const auto width = static_cast<std::size_t>(dimension_);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const auto cell = QuadtreeCellAt(options, &mesh.vertices.coordinates[i * width]);
      boxes_.push_back(cell->box);
      finest_ = std::max(finest_, cell->level);
    }
    for (const Feature& f : features) {
      if (f.kind == FeatureKind::kPoint) positions_[f.id] = f.position;
    }
  }
  int finest() const { return finest_; }
  // O(leaves).
  int Count(const Feature& f) const {
    const bool is_point = f.kind == FeatureKind::kPoint;
    const auto& p = is_point ? f.position : positions_.at(f.ends[0]);
    const auto& q = is_point ? f.position : positions_.at(f.ends[1]);
    return static_cast<int>(std::ranges::count_if(boxes_, [&](const Box& box) {
      return dimension_ == 2 ? Meets<2>(p, q, box) : Meets<3>(p, q, box);
    }));
  }

 private:
  template <int D>
  static bool Meets(const std::array<double, 3>& p, const std::array<double, 3>& q,
                    const Box& box) {
    geometry::Point<D> from, to;
    quadtree::Box<D> cell;
    for (int k = 0; k < D; ++k) {
      from[k] = p[k], to[k] = q[k];
      cell.lo[k] = box.lo[k], cell.hi[k] = box.hi[k];
    }
    return quadtree::MeetsSegment(from, to, cell);
  }

  const int dimension_;
  std::vector<Box> boxes_;
  int finest_ = 0;
  absl::flat_hash_map<FeatureId, std::array<double, 3>> positions_;
};

struct Figures {
  std::size_t vertices = 0;
  double build_ms = 0, load_ms = 0, edit_us = 0, operations = 0, changed = 0, per_bound = 0;
};

Figures Measure(const std::vector<Feature>& features, int dimension, MeshKind kind) {
  const MeshOptions options = OptionsOf(dimension, kind);
  Figures figures;
  double start = ThreadSeconds();
  const auto built = BuildMesh(features, options);
  figures.build_ms = 1e3 * (ThreadSeconds() - start);
  if (!built.ok()) {
    std::fprintf(stderr, "%s\n", built.status().ToString().c_str());
    std::exit(1);
  }
  figures.vertices = built->vertices.size();
  const auto mesh = *DynamicMesh::Create(options);
  const EditBatch all = AddAll(features);
  start = ThreadSeconds();
  if (!mesh->Apply(all).ok()) std::exit(1);
  figures.load_ms = 1e3 * (ThreadSeconds() - start);

  const std::vector<std::size_t> rows = FreeRows(features);
  test::Random random(7);
  std::unique_ptr<LeafCounter> leaves;
  if (kind == MeshKind::kQuadtree) {
    leaves = std::make_unique<LeafCounter>(*built, options, features);
  }
  std::vector<double> times;
  for (int i = 0; i < kEdits; ++i) {
    const Feature& f =
        features[rows[static_cast<std::size_t>(random.Below(static_cast<int>(rows.size())))]];
    double operations = 0;
    for (const EditBatch& batch : {EditBatch{Edit::Remove(f.id)}, EditBatch{Edit::Add(f)}}) {
      start = ThreadSeconds();
      const auto diff = mesh->Apply(batch);
      times.push_back(1e6 * (ThreadSeconds() - start));
      if (!diff.ok()) std::exit(1);
      operations += static_cast<double>(diff->work.executed + diff->work.dropped) / 2;
      figures.changed +=
          static_cast<double>(diff->added_vertices.size() + diff->removed_vertices.size()) /
          (2 * kEdits);
    }
    figures.operations += operations / kEdits;
    if (leaves != nullptr) {
      figures.per_bound += operations / (leaves->Count(f) * leaves->finest()) / kEdits;
    }
  }
  figures.edit_us = cli::Percentile(times, 0.5);
  return figures;
}

void Print(const std::string& scene, const char* kind, const Figures& f) {
  std::printf("| %s | %s | %zu | %.1f | %.1f | %.1f | %.1f | %.1f | ", scene.c_str(), kind,
              f.vertices, f.build_ms, f.load_ms, f.edit_us, f.operations, f.changed);
  if (f.per_bound > 0) std::printf("%.3f", f.per_bound);
  std::printf(" |\n");
  std::fflush(stdout);
}

int Run(int most) {
  std::printf(
      "| scene, features | kind | vertices | build, ms | load, ms | edit, us | operations | "
      "changed "
      "| / (m_f lg L/s) |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const Distribution d :
       {Distribution::kUniform, Distribution::kClustered, Distribution::kCircle,
        Distribution::kTwoScale, Distribution::kSegmentsTurned, Distribution::kParallel,
        Distribution::kSpaceUniform, Distribution::kSpaceClustered, Distribution::kLineAndCircle,
        Distribution::kSpaceTwoScale, Distribution::kTurnedGridEdges}) {
    const int dimension = test::DimensionOf(d);
    for (int n = 1000; n <= (dimension == 2 ? most : most / 10); n *= 10) {
      const std::vector<Feature> features = test::MakeFeatures(d, n, 1);
      const std::string scene = test::NameOf(d) + ", " + std::to_string(features.size());
      Print(scene, "quadtree", Measure(features, dimension, MeshKind::kQuadtree));
      Print(scene, "delaunay", Measure(features, dimension, MeshKind::kDelaunay));
    }
  }
  return 0;
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  const int most = argc > 1 ? std::atoi(argv[1]) : 100'000;
  if (most < 1000) {
    std::fputs("usage: dynmesh_kind_tables [MOST], at least 1000 points\n", stderr);
    return 2;
  }
  return dynmesh::Run(most);
}
