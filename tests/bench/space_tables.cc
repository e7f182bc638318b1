// 3D meshes as a table on standard output: size, vertices per second without a trace and with one,
// memory, and the cost of edits of one point.
//
//   dynmesh_space_tables [KIND-POINTS | FILE.node ...]
//
// At rho 2, on points of each kind and number given, such as sphere-10000, and on each file's;
// on a choice of kinds if nothing is given. Speeds and their ratio are medians of runs in turn.
// Half of the edits put a point among those of the input, half anywhere; each is undone before
// the next, and both ways count.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "client/cli/percentile.h"
#include "core/base/process_memory.h"
#include "core/io/space/space_input.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/bench/thread_clock.h"
#include "tests/support/space_workload.h"

namespace dynmesh {
namespace {

using test::Distribution;
using test::Random;

constexpr int kEdits = 200;
constexpr double kSeconds = 12;
constexpr std::size_t kMostRounds = 15;

MeshOptions OptionsFor(const std::vector<Feature>& points) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  options.box.lo.fill(INFINITY);
  options.box.hi.fill(-INFINITY);
  for (const Feature& f : points) {
    for (int k = 0; k < 3; ++k) {
      options.box.lo[k] = std::min(options.box.lo[k], f.position[k]);
      options.box.hi[k] = std::max(options.box.hi[k], f.position[k]);
    }
  }
  return options;
}

// Among the points or anywhere.
std::array<double, 3> AnyPlace(const std::vector<Feature>& points, const Box& box,
                               bool among_points, Random& random) {
  const double spacing = (box.hi[0] - box.lo[0]) / std::cbrt(static_cast<double>(points.size()));
  std::array<double, 3> p = {};
  const Feature& near = points[random.Below(static_cast<int>(points.size()))];
  for (int k = 0; k < 3; ++k) {
    const double u = random.Unit();
    p[k] = among_points
               ? std::clamp(near.position[k] + 0.3 * spacing * (u - 0.5), box.lo[k], box.hi[k])
               : box.lo[k] + u * (box.hi[k] - box.lo[k]);
  }
  return p;
}

struct Edits {
  std::vector<double> times;  // microseconds
  double executed = 0, changed = 0;
};

void Apply(DynamicMesh& mesh, const Edit& edit, Edits* edits) {
  const double start = ThreadSeconds();
  const auto diff = mesh.Apply({edit});
  if (!diff.ok()) return;  // too close to another point
  edits->times.push_back(1e6 * (ThreadSeconds() - start));
  edits->executed += static_cast<double>(diff->work.executed);
  edits->changed +=
      static_cast<double>(diff->added_vertices.size() + diff->removed_vertices.size());
}

Edits EditsOf(DynamicMesh& mesh, const std::vector<Feature>& points) {
  Edits edits;
  Random random(5);
  constexpr FeatureId kNew = FeatureId{1} << 60;
  for (int i = 0; i < kEdits; ++i) {
    const auto p = AnyPlace(points, mesh.options().box, i % 2 == 0, random);
    const std::size_t before = edits.times.size();
    Apply(mesh, Edit::Add(Feature::Point(kNew, p[0], p[1], p[2])), &edits);
    if (edits.times.size() > before) Apply(mesh, Edit::Remove(kNew), &edits);
  }
  return edits;
}

void PrintRow(const std::string& name, const std::vector<Feature>& points) {
  const MeshOptions options = OptionsFor(points);
  const EditBatch batch = AddAll(points);
  // In turn, for some seconds, since the machine's speed varies.
  std::vector<double> untraced_times, traced_times, ratios;
  absl::StatusOr<Mesh> built;
  std::unique_ptr<DynamicMesh> mesh;
  for (double spent = 0; spent < kSeconds && ratios.size() < kMostRounds;) {
    double start = ThreadSeconds();
    built = BuildMesh(points, options);
    untraced_times.push_back(ThreadSeconds() - start);
    mesh.reset();
    start = ThreadSeconds();
    mesh = DynamicMesh::Create(options).value();
    const auto loaded = mesh->Apply(batch);
    traced_times.push_back(ThreadSeconds() - start);
    if (!built.ok() || !loaded.ok()) {
      std::printf("%-24s refused: %s\n", name.c_str(), loaded.status().ToString().c_str());
      return;
    }
    ratios.push_back(traced_times.back() / untraced_times.back());
    spent += untraced_times.back() + traced_times.back();
  }
  const double untraced = cli::Percentile(untraced_times, .5);
  const double traced = cli::Percentile(traced_times, .5);
  const MeshStats stats = mesh->Stats();
  const auto vertices = static_cast<double>(stats.vertices);
  const Edits edits = EditsOf(*mesh, points);
  const auto count = static_cast<double>(edits.times.size());
  std::printf(
      "%-24s %8zu %8.0f | %8.0f %8.0f %5.2f | %6.0f | %7.0f %7.0f %7.1f %7.1f%s\n", name.c_str(),
      points.size(), vertices, vertices / untraced, vertices / traced, cli::Percentile(ratios, .5),
      static_cast<double>(stats.trace_bytes + stats.mesh_bytes) / vertices,
      cli::Percentile(edits.times, .5), cli::Percentile(edits.times, .99), edits.executed / count,
      edits.changed / count, built->hash == mesh->hash() ? "" : "  DIFFERENT");
}

// Of a kind, as in "uniform-1000", or of a file.
absl::StatusOr<std::vector<Feature>> PointsOf(const std::string& input) {
  static const std::map<std::string, Distribution> kKinds = {
      {"uniform", Distribution::kSpaceUniform},
      {"sphere", Distribution::kSphere},
      {"line", Distribution::kLineAndCircle},
      {"grid", Distribution::kSpaceGrid}};
  const std::size_t dash = input.find('-');
  const auto kind = kKinds.find(input.substr(0, dash));
  int count = 0;
  if (kind != kKinds.end() && dash != std::string::npos &&
      absl::SimpleAtoi(input.substr(dash + 1), &count) && count > 0) {
    return test::MakeSpaceFeatures(kind->second, count, 1);
  }
  auto read = io::ReadSpaceNodeFile(input);
  if (!read.ok()) return read.status();
  std::erase_if(read->features, [](const Feature& f) { return f.kind != FeatureKind::kPoint; });
  return std::move(read->features);
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  dynmesh::SetUpMemory(dynmesh::MemoryUse::kCommand);  // as `dynmesh` does
  using namespace dynmesh;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // rows take a while
  std::printf("%-24s %8s %8s | %8s %8s %5s | %6s | %7s %7s %7s %7s\n", "input", "points",
              "vertices", "V/s", "traced", "ratio", "B/V", "p50 us", "p99 us", "ops", "changed");
  std::vector<std::string> inputs(argv + 1, argv + argc);
  if (inputs.empty()) {
    inputs = {"uniform-1000", "uniform-10000", "uniform-100000", "sphere-10000",
              "line-2000",    "line-20000",    "grid-27000"};
  }
  for (const std::string& input : inputs) {
    const auto points = PointsOf(input);
    if (!points.ok()) {
      std::fprintf(stderr, "%s\n", points.status().ToString().c_str());
      return 1;
    }
    PrintRow(std::filesystem::path(input).filename().string(), *points);
  }
}
