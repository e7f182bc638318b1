// Meshes of space as a table on standard output: size, vertices per second without a trace and
// with one, memory, and what edits of one point cost.
//
//   dynmesh_space_tables [FILE.node ...]
//
// At rho 2, on points of several kinds and on each file's. Half of the edits put a point among
// those of the input, half anywhere; each is undone before the next, and both ways count.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/percentile.h"
#include "core/io/space_input.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/bench/thread_clock.h"
#include "tests/support/space_workload.h"

namespace dynmesh {
namespace {

using test::Distribution;
using test::Random;

constexpr int kEdits = 200;

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
  if (!diff.ok()) return;  // too close to another
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
  double start = ThreadSeconds();
  const auto built = BuildMesh(points, options);
  const double untraced = ThreadSeconds() - start;
  start = ThreadSeconds();
  const std::unique_ptr<DynamicMesh> mesh = DynamicMesh::Create(options).value();
  const auto loaded = mesh->Apply(AddAll(points));
  const double traced = ThreadSeconds() - start;
  if (!built.ok() || !loaded.ok()) {
    std::printf("%-24s refused: %s\n", name.c_str(), loaded.status().ToString().c_str());
    return;
  }
  const MeshStats stats = mesh->Stats();
  const auto vertices = static_cast<double>(stats.vertices);
  const Edits edits = EditsOf(*mesh, points);
  const auto count = static_cast<double>(edits.times.size());
  std::printf(
      "%-24s %8zu %8.0f | %8.0f %8.0f %5.2f | %6.0f | %7.0f %7.0f %7.1f %7.1f%s\n", name.c_str(),
      points.size(), vertices, vertices / untraced, vertices / traced, traced / untraced,
      static_cast<double>(stats.trace_bytes + stats.mesh_bytes) / vertices,
      cli::Percentile(edits.times, .5), cli::Percentile(edits.times, .99), edits.executed / count,
      edits.changed / count, built->hash == mesh->hash() ? "" : "  DIFFERENT");
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  using namespace dynmesh;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // rows take a while
  std::printf("%-24s %8s %8s | %8s %8s %5s | %6s | %7s %7s %7s %7s\n", "input", "points",
              "vertices", "V/s", "traced", "ratio", "B/V", "p50 us", "p99 us", "ops", "changed");
  const std::vector<std::pair<std::string, std::pair<Distribution, int>>> kinds = {
      {"uniform", {Distribution::kSpaceUniform, 1'000}},
      {"uniform", {Distribution::kSpaceUniform, 10'000}},
      {"uniform", {Distribution::kSpaceUniform, 100'000}},
      {"sphere", {Distribution::kSphere, 10'000}},
      {"line and circle", {Distribution::kLineAndCircle, 2'000}},
      {"line and circle", {Distribution::kLineAndCircle, 20'000}},
      {"grid", {Distribution::kSpaceGrid, 27'000}}};
  for (const auto& [name, kind] : kinds) {
    PrintRow(name, test::MakeSpaceFeatures(kind.first, kind.second, 1));
  }
  for (int i = 1; i < argc; ++i) {
    const auto input = io::ReadSpaceNodeFile(argv[i]);
    if (!input.ok()) {
      std::fprintf(stderr, "%s\n", input.status().ToString().c_str());
      return 1;
    }
    std::vector<Feature> points;
    for (const Feature& f : input->features) {
      if (f.kind == FeatureKind::kPoint) points.push_back(f);
    }
    PrintRow(std::filesystem::path(argv[i]).filename().string(), points);
  }
}
