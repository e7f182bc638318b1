// The latency of single edits to the far percentiles: points are removed, added and moved at random
// in a mesh of uniform points. CSV on standard output.
//
//   dynmesh_latency_tables POINTS EDITS [DIMENSION]
//
// A row for each kind of mesh: microseconds of Apply, by the clock on the wall, so what the machine
// does meanwhile counts, too; and by this thread's processor.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "client/cli/percentile.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/bench/thread_clock.h"
#include "tests/support/workload.h"

namespace dynmesh {
namespace {

double WallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void Print(const char* kind, const char* clock, std::vector<double> times) {
  std::printf("%s,%s", kind, clock);
  for (const double part : {0.5, 0.9, 0.99, 0.999, 0.9999, 1.0}) {
    std::printf(",%.1f", cli::Percentile(times, part));
  }
  std::printf("\n");
  std::fflush(stdout);
}

int Measure(int n, int edits, int dimension, MeshKind kind) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.kind = kind;
  const auto mesh = *DynamicMesh::Create(options);
  std::vector<Feature> features = test::MakeFeatures(
      dimension == 2 ? test::Distribution::kUniform : test::Distribution::kSpaceUniform, n, 1);
  if (!mesh->Apply(AddAll(features)).ok()) return 1;
  test::Random random(3);
  std::vector<double> wall, processor;
  const auto apply = [&](const EditBatch& batch) {
    const double start = WallSeconds(), busy = ThreadSeconds();
    const bool ok = mesh->Apply(batch).ok();
    processor.push_back(1e6 * (ThreadSeconds() - busy));
    wall.push_back(1e6 * (WallSeconds() - start));
    return ok;
  };
  // A third each of removals, additions and moves.
  while (wall.size() < static_cast<std::size_t>(edits)) {
    Feature& f =
        features[static_cast<std::size_t>(random.Below(static_cast<int>(features.size())))];
    Feature moved = f;
    for (int k = 0; k < dimension; ++k) moved.position[static_cast<std::size_t>(k)] = random.Unit();
    if (!apply({Edit::Move(f.id, moved.position[0], moved.position[1], moved.position[2])}))
      return 1;
    f = moved;
    if (!apply({Edit::Remove(f.id)}) || !apply({Edit::Add(f)})) return 1;
  }
  const char* name = kind == MeshKind::kQuadtree ? "quadtree" : "delaunay";
  Print(name, "wall", wall);
  Print(name, "processor", processor);
  return 0;
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 0, edits = argc > 2 ? std::atoi(argv[2]) : 0;
  const int dimension = argc > 3 ? std::atoi(argv[3]) : 2;
  if (n < 1 || edits < 1 || (dimension != 2 && dimension != 3)) {
    std::fputs("usage: dynmesh_latency_tables POINTS EDITS [DIMENSION]\n", stderr);
    return 2;
  }
  std::printf("kind,clock,p50,p90,p99,p99.9,p99.99,greatest\n");
  return dynmesh::Measure(n, edits, dimension, dynmesh::MeshKind::kDelaunay) |
         dynmesh::Measure(n, edits, dimension, dynmesh::MeshKind::kQuadtree);
}
