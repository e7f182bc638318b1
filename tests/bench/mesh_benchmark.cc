// Meshing from scratch and edits, beside peers: CGAL's 2D Delaunay mesher, and the program
// Triangle where there is one. They refine the same points in the same box to the same angle, but
// keep no trace.
//
//   dynmesh_mesh_benchmark [--triangle=PROGRAM] [--dynmesh=PROGRAM]
//       --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true
//
// `vertices/s` counts output vertices. Edits add a point and remove it again: `p50` and
// `p99` are microseconds of Apply.
//
// `process` rows are whole programs, from reading a file of points to having written the mesh, in
// processor time: `triangle` and `dynmesh mesh`. Of Triangle, `own_ms` is what it says itself that
// Delaunay triangulation, segments and quality took, without reading and writing, and `own_cpu_ms`
// that part of the processor time: to be compared with the processor time of `static`. Without
// `--triangle` the PATH is searched; without `--dynmesh` the program beside this one is taken.
// Where there is none, there are no such rows, and a line says so.
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_mesh_face_base_2.h>
#include <CGAL/Delaunay_mesh_size_criteria_2.h>
#include <CGAL/Delaunay_mesh_vertex_base_2.h>
#include <CGAL/Delaunay_mesher_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/cli/percentile.h"
#include "core/base/process_memory.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/bench/child_process.h"
#include "tests/support/temp_folder.h"
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

// --- From scratch, whole programs ---------------------------------------------------------

// The angle that radius / edge <= quality leaves at least, in degrees.
double LeastAngle(double quality) {
  return std::asin(1 / (2 * quality)) * (180 / std::numbers::pi);
}

std::string Exactly(double x) {
  std::array<char, 32> text;
  return {text.data(),
          static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%.17g", x))};
}

// The same work as a file: points, and for Triangle the box that a mesh of ours has around them.
std::string PointsAsText(const std::vector<Feature>& points, const Box* box) {
  std::vector<std::array<double, 2>> places;
  if (box != nullptr) {
    places = {{box->lo[0], box->lo[1]},
              {box->hi[0], box->lo[1]},
              {box->hi[0], box->hi[1]},
              {box->lo[0], box->hi[1]}};
  }
  for (const Feature& f : points) places.push_back({f.position[0], f.position[1]});
  std::string text = std::to_string(places.size()) + " 2 0 0\n";
  for (std::size_t i = 0; i < places.size(); ++i) {
    text +=
        std::to_string(i + 1) + " " + Exactly(places[i][0]) + " " + Exactly(places[i][1]) + "\n";
  }
  if (box != nullptr) text += "4 0\n1 1 2\n2 2 3\n3 3 4\n4 4 1\n0\n";
  return text;
}

// The sum of the numbers that stand behind `label` at the start of a line.
double SumBehind(std::string_view text, std::string_view label) {
  double sum = 0;
  for (std::size_t at = text.find(label); at != std::string_view::npos;
       at = text.find(label, at + 1)) {
    sum += std::atof(std::string(text.substr(at + label.size(), 20)).c_str());
  }
  return sum;
}

void TriangleProcess(benchmark::State& state, const std::string& program, Distribution distribution,
                     double quality) {
  const auto features = test::MakeFeatures(distribution, static_cast<int>(state.range(0)), 1);
  const Box box = DomainBox(WithQuality(quality));
  const test::TempFolder folder;
  const std::string input = folder.Write("points.poly", PointsAsText(features, &box));
  const std::string angle = "-pq" + Exactly(LeastAngle(quality));
  std::string said;
  double spent = 0;
  for (auto _ : state) {
    const auto seconds = SecondsOfProcess({program, angle, input}, folder.Path("said"));
    said = folder.Read("said");
    if (!seconds.has_value()) return state.SkipWithError("triangle has failed");
    spent = *seconds;
    state.SetIterationTime(spent);
  }
  CountVertices(state, static_cast<std::size_t>(SumBehind(said, "Mesh vertices: ")));
  const double own = SumBehind(said, "Delaunay milliseconds: ") +
                     SumBehind(said, "Segment milliseconds: ") +
                     SumBehind(said, "Quality milliseconds: ");
  state.counters["own_ms"] = own;
  state.counters["own_cpu_ms"] =
      1e3 * spent * own / SumBehind(said, "Total running milliseconds: ");
}

void OurProcess(benchmark::State& state, const std::string& program, Distribution distribution,
                double quality) {
  const auto features = test::MakeFeatures(distribution, static_cast<int>(state.range(0)), 1);
  const test::TempFolder folder;
  const std::string input = folder.Write("points.node", PointsAsText(features, nullptr));
  const std::string mesh = folder.Path("mesh.node");
  for (auto _ : state) {
    const auto seconds = SecondsOfProcess(
        {program, "mesh", input, "--box", "0,0,1,1", "--rho", Exactly(quality), "-o", mesh},
        folder.Path("said"));
    if (!seconds.has_value()) return state.SkipWithError("dynmesh has failed");
    state.SetIterationTime(*seconds);
  }
  CountVertices(state, static_cast<std::size_t>(std::atof(folder.Read("mesh.node").c_str())));
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

// The paths of programs to compare; empty if there is none.
struct Programs {
  std::string triangle, dynmesh;
};

std::string FoundInPath(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::string_view rest = path == nullptr ? "" : path;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    const auto file = std::filesystem::path(rest.substr(0, end)) / name;
    if (access(file.c_str(), X_OK) == 0) return file.string();
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return "";
}

// Takes our own flags out of argv.
Programs TakePrograms(int* argc, char** argv) {
  Programs programs;
  const auto beside = std::filesystem::path(argv[0]).replace_filename("dynmesh");
  if (access(beside.c_str(), X_OK) == 0) programs.dynmesh = beside.string();
  programs.triangle = FoundInPath("triangle");
  int kept = 1;
  for (int i = 1; i < *argc; ++i) {
    const std::string_view flag = argv[i];
    if (flag.starts_with("--triangle=")) {
      programs.triangle = flag.substr(flag.find('=') + 1);
    } else if (flag.starts_with("--dynmesh=")) {
      programs.dynmesh = flag.substr(flag.find('=') + 1);
    } else {
      argv[kept++] = argv[i];
    }
  }
  *argc = kept;
  return programs;
}

void RegisterProcesses(const Programs& programs) {
  const auto with = [&](const char* name, const std::string& program, auto function) {
    if (program.empty() || access(program.c_str(), X_OK) != 0) {
      std::fprintf(stderr, "no program `%s`: no rows of it; --%s=PROGRAM names one\n", name, name);
      return;
    }
    for (const double quality : {kRoot2, 1.0}) {
      const std::string rho = quality == 1 ? "1" : "sqrt2";
      benchmark::RegisterBenchmark((std::string("process/") + name + "/uniform/rho=" + rho).c_str(),
                                   [=](benchmark::State& state) {
                                     function(state, program, Distribution::kUniform, quality);
                                   })
          ->Arg(100'000)
          ->Arg(1'000'000)
          ->Unit(benchmark::kMillisecond)
          ->Iterations(1)
          ->UseManualTime();
    }
  };
  with("triangle", programs.triangle, TriangleProcess);
  with("dynmesh", programs.dynmesh, OurProcess);
}

void Register() {
  using benchmark::RegisterBenchmark;
  for (const auto& [name, distribution] :
       {std::pair("uniform", Distribution::kUniform),
        std::pair("cluster", Distribution::kClustered), std::pair("grid", Distribution::kGrid)}) {
    for (const double quality : {kRoot2, 1.0}) {
      const std::string suffix = std::string("/") + name + "/rho=" + (quality == 1 ? "1" : "sqrt2");
      const auto with = [&](const char* what, auto function) {
        return RegisterBenchmark((what + suffix).c_str(), function, distribution, quality)
            ->Arg(100'000)
            ->Unit(benchmark::kMillisecond)
            ->Iterations(1);
      };
      auto* const untraced = with("static", Static);
      if (distribution == Distribution::kUniform) untraced->Arg(1'000'000);
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
  dynmesh::SetUpMemory(dynmesh::MemoryUse::kCommand);  // as `dynmesh` does
  const dynmesh::Programs programs = dynmesh::TakePrograms(&argc, argv);
  dynmesh::RegisterProcesses(programs);
  dynmesh::Register();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
