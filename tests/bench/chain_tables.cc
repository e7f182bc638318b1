// How far one edit is felt along a chain of vertices that could each depend on the next (Hudson,
// Fig. 4.8): n points, evenly spaced on a line in 2D. CSV on standard output.
//
//   dynmesh_chain_tables [MOST]    100, 300, 1,000, ... up to MOST (default: 10,000) points
//
// The order of operations of equal length is that of a hash of coordinates. `order` says how the
// points' hashes run along the line: random, as coordinates have them; or ascending, by last bits
// of y that were searched for. So an adversary that knows the hash makes the mesher work in the
// order of coordinates. A point is removed and added again: `operations` run, and the distance in
// spacings from it to the farthest vertex that came or went, of those within 3 spacings of the line
// and between its ends; mean and greatest of 200 edits.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/geometry/point.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/support/workload.h"

namespace dynmesh {
namespace {

constexpr int kEdits = 200;

std::vector<Feature> Line(int n, bool ascending) {
  std::vector<Feature> features;
  for (int i = 0; i < n; ++i) {
    geometry::Point2 p = {{0.05 + 0.9 * i / n, 0.5}};
    if (ascending) {
      // The i-th of n equal parts of all hashes.
      const auto part = [&](int k) {
        return static_cast<double>(k) / n * static_cast<double>(~std::uint64_t{0});
      };
      for (auto h = static_cast<double>(geometry::HashOf(p)); h < part(i) || h >= part(i + 1);) {
        p[1] = std::nextafter(p[1], 1);
        h = static_cast<double>(geometry::HashOf(p));
      }
    }
    features.push_back(Feature::Point(features.size() + 1, p[0], p[1]));
  }
  return features;
}

class Positions {
 public:
  void Add(const VertexColumns& vertices) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      at_[vertices.ids[i]] = {{vertices.coordinates[2 * i], vertices.coordinates[2 * i + 1]}};
    }
  }
  const geometry::Point2& at(VertexId id) const { return at_.at(id); }

 private:
  absl::flat_hash_map<VertexId, geometry::Point2> at_;
};

void Measure(int n, bool ascending) {
  const double spacing = 0.9 / n;
  const auto mesh = *DynamicMesh::Create(MeshOptions());
  const std::vector<Feature> features = Line(n, ascending);
  if (!mesh->Apply(AddAll(features)).ok()) std::exit(1);
  Positions positions;
  positions.Add(mesh->Snapshot().vertices);
  test::Random random(5);
  double operations = 0, far = 0, most_operations = 0, farthest = 0;
  for (int i = 0; i < kEdits; ++i) {
    const Feature& f = features[static_cast<std::size_t>(random.Below(n))];
    double run = 0, reach = 0;
    for (const EditBatch& batch : {EditBatch{Edit::Remove(f.id)}, EditBatch{Edit::Add(f)}}) {
      const auto diff = mesh->Apply(batch);
      if (!diff.ok()) std::exit(1);
      run += static_cast<double>(diff->work.executed) / 2;
      positions.Add(diff->added_vertices);
      for (const auto* ids : {&diff->removed_vertices, &diff->added_vertices.ids}) {
        for (const VertexId id : *ids) {
          const geometry::Point2& p = positions.at(id);
          if (std::fabs(p[1] - 0.5) > 3 * spacing || p[0] < 0.05 || p[0] > 0.95) continue;
          reach = std::max(reach, std::fabs(p[0] - f.position[0]) / spacing);
        }
      }
    }
    operations += run / kEdits;
    far += reach / kEdits;
    most_operations = std::max(most_operations, run);
    farthest = std::max(farthest, reach);
  }
  std::printf("%d,%s,%.1f,%.0f,%.1f,%.1f\n", n, ascending ? "ascending" : "random", operations,
              most_operations, far, farthest);
  std::fflush(stdout);
}

int Run(int most) {
  std::printf("points,order,operations,most_operations,reach,farthest\n");
  for (int n = 100, k = 0; n <= most; n = k++ % 2 == 0 ? n * 3 : n / 3 * 10) {
    Measure(n, false);
    Measure(n, true);
  }
  return 0;
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  const int most = argc > 1 ? std::atoi(argv[1]) : 10'000;
  if (most < 100) {
    std::fputs("usage: dynmesh_chain_tables [MOST], at least 100 points\n", stderr);
    return 2;
  }
  return dynmesh::Run(most);
}
