// Meshing from scratch and edits, beside a peer: CGAL's 2D Delaunay mesher, which
// refines the same points in the same box to the same angle, but keeps no trace.
//
//   dynmesh_mesh_benchmark --benchmark_repetitions=5 --benchmark_enable_random_interleaving
//
// `vertices/s` counts output vertices. Edits add a point and remove it again: `p50` and
// `p99` are microseconds of Apply.
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesh_vertex_base_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <benchmark/benchmark.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/percentile.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/support/workload.h"

namespace dynmesh {
namespace {

using test::Distribution;

MeshOptions WithQuality(double quality) {
  MeshOptions options;
  options.quality = quality;
  return options;
}

void CountVertices(benchmark::State& state, std::size_t vertices) {
  state.counters["vertices"] = static_cast<double>(vertices);
  state.counters["vertices/s"] =
      benchmark::Counter(static_cast<double>(vertices) * static_cast<double>(state.iterations()),
                         benchmark::Counter::kIsRate);
}

// --- From scratch -----------------------------------------------------------------------

void Static(benchmark::State& state, Distribution distribution, double quality) {
  const auto features = test::MakeFeatures(distribution, static_cast<int>(state.range(0)), 1);
  std::size_t vertices = 0;
  for (auto _ : state) {
    const auto mesh = BuildMesh(features, WithQuality(quality));
    if (!mesh.ok()) return state.SkipWithError("refused");
    vertices = mesh->vertices.size();
  }
  CountVertices(state, vertices);
}

void Traced(benchmark::State& state, Distribution distribution, double quality) {
  const EditBatch batch =
      AddAll(test::MakeFeatures(distribution, static_cast<int>(state.range(0)), 1));
  std::size_t vertices = 0;
  std::unique_ptr<DynamicMesh> mesh;
  for (auto _ : state) {
    mesh = *DynamicMesh::Create(WithQuality(quality));
    const auto diff = mesh->Apply(batch);
    if (!diff.ok()) return state.SkipWithError("refused");
    state.PauseTiming();  // giving the memory back is not meshing
    vertices = mesh->Stats().vertices;
    mesh.reset();
    state.ResumeTiming();
  }
  CountVertices(state, vertices);
}

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertices = CGAL::Delaunay_mesh_vertex_base_2<Kernel>;
using Faces = CGAL::Delaunay_mesh_face_base_2<Kernel>;
using Cdt = CGAL::Constrained_Delaunay_triangulation_2<
    Kernel, CGAL::Triangulation_data_structure_2<Vertices, Faces>>;
using Criteria = CGAL::Delaunay_mesh_size_criteria_2<Cdt>;

// radius / edge <= quality is sin(least angle) >= 1 / (2 quality).
void CgalMesh2(benchmark::State& state, Distribution distribution, double quality) {
  const auto features = test::MakeFeatures(distribution, static_cast<int>(state.range(0)), 1);
  const Box domain = DomainBox(WithQuality(quality));
  std::vector<Kernel::Point_2> points;
  for (const Feature& f : features) points.emplace_back(f.position[0], f.position[1]);
  std::size_t vertices = 0;
  std::optional<Cdt> mesh;
  for (auto _ : state) {
    Cdt& cdt = mesh.emplace();
    const Kernel::Point_2 corners[4] = {{domain.lo[0], domain.lo[1]},
                                        {domain.hi[0], domain.lo[1]},
                                        {domain.hi[0], domain.hi[1]},
                                        {domain.lo[0], domain.hi[1]}};
    for (int i = 0; i < 4; ++i) cdt.insert_constraint(corners[i], corners[(i + 1) % 4]);
    cdt.insert(points.begin(), points.end());
    CGAL::refine_Delaunay_mesh_2(cdt, Criteria(1 / (4 * quality * quality), 0));
    state.PauseTiming();
    vertices = cdt.number_of_vertices();
    mesh.reset();
    state.ResumeTiming();
  }
  CountVertices(state, vertices);
}

// --- Edits ------------------------------------------------------------------------------

void EditOnePoint(benchmark::State& state, Distribution distribution, double quality) {
  const auto created = DynamicMesh::Create(WithQuality(quality));
  DynamicMesh& mesh = **created;
  const auto features = test::MakeFeatures(distribution, static_cast<int>(state.range(0)), 1);
  if (!mesh.Apply(AddAll(features)).ok()) return state.SkipWithError("refused");
  test::Random random(7);
  std::vector<double> times;
  double executed = 0, changed = 0;
  for (auto _ : state) {
    const FeatureId id = FeatureId{1} << 40;
    for (const Edit& edit :
         {Edit::Add(Feature::Point(id, random.Unit(), random.Unit())), Edit::Remove(id)}) {
      const auto diff = mesh.Apply({edit});
      if (!diff.ok()) return state.SkipWithError("refused");
      times.push_back(diff->work.microseconds);
      executed += static_cast<double>(diff->work.executed);
      changed += static_cast<double>(diff->added_vertices.size() + diff->removed_vertices.size());
    }
  }
  const double n = static_cast<double>(times.size());
  state.counters["p50"] = cli::Percentile(times, 0.5);
  state.counters["p99"] = cli::Percentile(times, 0.99);
  state.counters["executed"] = executed / n;
  state.counters["vertices_changed"] = changed / n;
}

constexpr double kRoot2 = 1.4142135623730951;

void Register() {
  using benchmark::RegisterBenchmark;
  for (const auto& [name, distribution] :
       {std::pair("uniform", Distribution::kUniform),
        std::pair("cluster", Distribution::kClustered), std::pair("grid", Distribution::kGrid)}) {
    for (const double quality : {kRoot2, 1.0}) {
      const std::string suffix = std::string("/") + name + "/rho=" + (quality == 1 ? "1" : "sqrt2");
      const auto with = [&](const char* what, auto function) {
        RegisterBenchmark((what + suffix).c_str(), function, distribution, quality)
            ->Arg(100'000)
            ->Unit(benchmark::kMillisecond)
            ->Iterations(1);
      };
      with("static", Static);
      with("traced", Traced);
      with("cgal_mesh_2", CgalMesh2);
    }
  }
  for (const double quality : {2.0, kRoot2}) {
    RegisterBenchmark((std::string("edit/uniform/rho=") + (quality == 2 ? "2" : "sqrt2")).c_str(),
                      EditOnePoint, Distribution::kUniform, quality)
        ->Arg(1'000)
        ->Arg(100'000)
        ->Unit(benchmark::kMicrosecond)
        ->Iterations(2'000);
  }
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  dynmesh::Register();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
