// What SVR's point location costs, as tables of comma-separated values on standard output.
//
//   dynmesh_location_tables structures FILE.node ...   each structure: vertices and counts
//   dynmesh_location_tables warp FILE.node ...         the default one, for values of k
//   dynmesh_location_tables 4d COUNT ...               so many uniform points in 4D
//
// Points alone, circumradius / shortest edge at most 2, in a domain of 8 times their extent (4D: 4
// times). Vertices are without those of the border. Seconds are of this thread's processor, the
// least of three runs (4D: of one).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/space/space_input.h"
#include "core/svr/svr.h"
#include "tests/bench/thread_clock.h"
#include "tests/core/svr/svr_of_points.h"
#include "tests/support/point_layouts.h"

namespace dynmesh {
namespace {

using geometry::Point;
using svr::Kernel;
using svr::SvrOfPoints;

constexpr int kRuns = 3;
constexpr double kWarps[] = {0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99};

[[noreturn]] void Fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(1);
}

struct Cloud {
  std::string name;
  std::vector<Point<3>> points;
  svr::Options<3> options;
};
Cloud Read(const std::string& path) {
  const auto read = io::ReadSpaceNodeFile(path);
  if (!read.ok()) Fail(read.status().ToString());
  Cloud cloud;
  cloud.name = std::filesystem::path(path).stem().string();
  for (const Feature& f : read->features) {
    if (f.kind == FeatureKind::kPoint) cloud.points.push_back({f.position});
  }
  std::sort(cloud.points.begin(), cloud.points.end());
  const auto same = std::unique(cloud.points.begin(), cloud.points.end());
  cloud.points.erase(same, cloud.points.end());
  if (cloud.points.size() < 2) Fail(path + ": fewer than two points");
  Point<3> lo = cloud.points[0], hi = lo;
  double extent = 0;
  for (int k = 0; k < 3; ++k) {
    for (const Point<3>& p : cloud.points)
      lo[k] = std::min(lo[k], p[k]), hi[k] = std::max(hi[k], p[k]);
    extent = std::max(extent, hi[k] - lo[k]);
  }
  for (int k = 0; k < 3; ++k) {
    cloud.options.lo[k] = (lo[k] + hi[k]) / 2 - 4 * extent;
    cloud.options.hi[k] = (lo[k] + hi[k]) / 2 + 4 * extent;
  }
  cloud.options.border_cells = 8;
  return cloud;
}

struct Figures {
  std::size_t vertices = 0;
  svr::LocationCounts counts;
  double seconds = INFINITY;
};
template <class Location>
Figures Measure(const Cloud& cloud) {
  Figures figures;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Point<3>> points = cloud.points;
    const double start = ThreadSeconds();
    SvrOfPoints<3, Location> of(cloud.options, std::move(points));
    of.svr.Run([] { return false; });
    figures.seconds = std::min(figures.seconds, ThreadSeconds() - start);
    figures.vertices = of.mesh.vertex_count() - of.input.border_count();
    figures.counts = of.svr.location().counts();
  }
  return figures;
}

template <class Location>
void PrintStructure(const Cloud& cloud, const char* structure) {
  const Figures f = Measure<Location>(cloud);
  std::printf("\"%s\",%zu,%s,%zu,%zu,%zu,%zu,%zu,%.3f\n", cloud.name.c_str(), cloud.points.size(),
              structure, f.vertices, std::size_t{f.counts.queries}, std::size_t{f.counts.looked_at},
              std::size_t{f.counts.reassigned}, std::size_t{f.counts.predicates}, f.seconds);
  std::fflush(stdout);
}
void PrintStructures(const std::vector<std::string>& paths) {
  std::puts("input,points,structure,vertices,queries,looked at,reassigned,predicates,seconds");
  for (const std::string& path : paths) {
    Cloud cloud = Read(path);
    cloud.options.asks_tree_first = false;
    PrintStructure<svr::BallLocation<3>>(cloud, "balls");
    PrintStructure<svr::SimplexLocation<3>>(cloud, "simplices");
    PrintStructure<svr::VoronoiLocation<3, false>>(cloud, "Voronoi cells");
    PrintStructure<svr::VoronoiLocation<3, true>>(cloud, "shells");
    cloud.options.asks_tree_first = true;
    PrintStructure<svr::VoronoiLocation<3, true>>(cloud, "shells after a tree");
  }
}

void PrintWarps(const std::vector<std::string>& paths) {
  std::puts("input,points,k,vertices,queries,looked at,seconds");
  for (const std::string& path : paths) {
    Cloud cloud = Read(path);
    for (const double k : kWarps) {
      cloud.options.k = k;
      const Figures f = Measure<svr::VoronoiLocation<3, true>>(cloud);
      std::printf("\"%s\",%zu,%.2f,%zu,%zu,%zu,%.3f\n", cloud.name.c_str(), cloud.points.size(), k,
                  f.vertices, std::size_t{f.counts.queries}, std::size_t{f.counts.looked_at},
                  f.seconds);
      std::fflush(stdout);
    }
  }
}

void PrintIn4D(const std::vector<std::string>& counts) {
  std::puts("points,vertices,simplices,worst ratio,seconds");
  for (const std::string& count : counts) {
    svr::Options<4> options;
    options.lo.c.fill(-1.5);
    options.hi.c.fill(2.5);
    options.border_cells = 4;
    std::vector<Point<4>> points =
        test::PointsOf<4>(test::Layout::kUniform, std::atoi(count.c_str()), 3);
    const double start = ThreadSeconds();
    SvrOfPoints<4> of(options, std::move(points));
    of.svr.Run([] { return false; });
    const double seconds = ThreadSeconds() - start;
    std::string why;
    if (!of.mesh.Check(&why)) Fail(why);
    std::printf("%s,%zu,%zu,%.4f,%.1f\n", count.c_str(),
                of.mesh.vertex_count() - of.input.border_count(), of.mesh.simplex_count(),
                std::sqrt(of.svr.WorstSquaredRatio()), seconds);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + std::min(argc, 2), argv + argc);
  const std::string_view table = argc > 2 ? argv[1] : "";
  if (table == "structures") {
    dynmesh::PrintStructures(arguments);
  } else if (table == "warp") {
    dynmesh::PrintWarps(arguments);
  } else if (table == "4d") {
    dynmesh::PrintIn4D(arguments);
  } else {
    std::fputs(
        "usage: dynmesh_location_tables structures|warp FILE.node ...\n"
        "       dynmesh_location_tables 4d COUNT ...\n",
        stderr);
    return 2;
  }
  return 0;
}
