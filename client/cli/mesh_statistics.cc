#include "client/cli/mesh_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cli/json.h"
#include "client/cli/percentile.h"

namespace dynmesh::cli {
namespace {

// Rounding may put the least angle of an equilateral triangle above 60.
template <std::size_t N>
void Count(double angle, std::array<std::uint64_t, N>& counts) {
  const auto degree = static_cast<std::size_t>(std::max(angle, 0.0));
  ++counts[std::min(degree, N - 1)];
}

template <std::size_t N>
std::vector<std::uint64_t> ToVector(const std::array<std::uint64_t, N>& counts) {
  return {counts.begin(), counts.end()};
}

double AreaOf(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t) {
  const auto& a = mesh.vertices[t[0]];
  const auto& b = mesh.vertices[t[1]];
  const auto& c = mesh.vertices[t[2]];
  return ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
}

std::vector<RegionStatistics> CountRegions(const io::IndexedMesh& mesh) {
  std::vector<RegionStatistics> regions(mesh.regions.count() + 1);
  for (std::size_t k = 1; k < regions.size(); ++k) {
    regions[k].polygons = mesh.regions.polygons[k - 1];
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    RegionStatistics& region = regions[mesh.regions.Of(i)];
    ++region.simplices;
    region.area += AreaOf(mesh, mesh.triangles[i]);
  }
  return regions;
}

}  // namespace

double LeastAngle(double rho) { return std::asin(1 / (2 * rho)) * (180 / std::numbers::pi); }

MeshStatistics ComputeStatistics(const io::IndexedMesh& mesh, double rho) {
  MeshStatistics s;
  s.rho = rho;
  s.vertices = mesh.vertices.size();
  s.simplices = mesh.triangles.size();
  s.subsegments = static_cast<std::uint64_t>(
      std::count_if(mesh.edges.begin(), mesh.edges.end(),
                    [](const io::IndexedMesh::Edge& e) { return e.owner != kNoFeature; }));
  MeshOptions options;
  options.quality = rho;
  s.quality = MeasureQuality(io::ToMesh(mesh), options);
  std::vector<double> least;
  least.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const TriangleQuality q = io::MeasureTriangle(mesh, i);
    Count(q.min_angle_deg, s.least_angles);
    for (const double angle : q.angles_deg) Count(angle, s.angles);
    least.push_back(q.min_angle_deg);
  }
  s.regions = CountRegions(mesh);
  if (!least.empty()) s.median_min_angle_deg = Percentile(std::move(least), 0.5);
  return s;
}

std::string StatisticsText(const MeshStatistics& s) {
  std::string text = absl::StrFormat(
      "vertices           %d\n"
      "triangles          %d\n"
      "subsegments        %d\n"
      "angles             %.2f to %.2f degrees\n"
      "least angle        %.2f degrees in the median triangle\n"
      "worst radius-edge  %.6g\n"
      "over rho           %d of rho %.6g (%d exempt, %d of them by the termination guard)\n"
      "rho allows         %.2f to %.2f degrees\n",
      s.vertices, s.simplices, s.subsegments, s.quality.min_angle_deg, s.quality.max_angle_deg,
      s.median_min_angle_deg, s.quality.worst_radius_edge, s.quality.over_rho, s.rho,
      s.quality.exempt, s.quality.exempt_by_guard, LeastAngle(s.rho), 180 - 2 * LeastAngle(s.rho));
  if (s.regions.size() > 1) {
    absl::StrAppendFormat(&text, "\n%12s  %12s  %s\n", "triangles", "area", "inside");
    for (const RegionStatistics& region : s.regions) {
      const std::string polygons = io::FormatPolygons(region.polygons);
      absl::StrAppendFormat(&text, "%12d  %12.6g  %s\n", region.simplices, region.area,
                            polygons.empty() ? "no polygon" : polygons);
    }
  }
  absl::StrAppendFormat(&text, "\n%7s  %12s  %12s\n", "degrees", "least angles", "all angles");
  for (std::size_t i = 0; i < s.angles.size(); ++i) {
    const std::uint64_t least = i < s.least_angles.size() ? s.least_angles[i] : 0;
    if (s.angles[i] == 0 && least == 0) continue;
    absl::StrAppendFormat(&text, "%3d-%-3d  %12d  %12d\n", i, i + 1, least, s.angles[i]);
  }
  return text;
}

std::string StatisticsJson(const MeshStatistics& s) {
  std::vector<JsonObject> regions;
  for (const RegionStatistics& region : s.regions) {
    std::vector<std::string> polygons;
    for (const FeatureId id : region.polygons) polygons.push_back(std::to_string(id));
    regions.push_back(JsonObject()
                          .AddTexts("polygons", polygons)
                          .Add("simplices", region.simplices)
                          .Add("area", region.area));
  }
  return JsonObject()
      .Add("vertices", s.vertices)
      .Add("simplices", s.simplices)
      .Add("subsegments", s.subsegments)
      .Add("rho", s.rho)
      .Add("worst_radius_edge", s.quality.worst_radius_edge)
      .Add("min_angle_deg", s.quality.min_angle_deg)
      .Add("max_angle_deg", s.quality.max_angle_deg)
      .Add("median_min_angle_deg", s.median_min_angle_deg)
      .Add("over_rho", s.quality.over_rho)
      .Add("exempt", s.quality.exempt)
      .Add("exempt_by_guard", s.quality.exempt_by_guard)
      .Add("rho_min_angle_deg", LeastAngle(s.rho))
      .Add("rho_max_angle_deg", 180 - 2 * LeastAngle(s.rho))
      .Add("histogram_step_deg", 1)
      .AddCounts("least_angle_histogram", ToVector(s.least_angles))
      .AddCounts("angle_histogram", ToVector(s.angles))
      .AddObjects("regions", regions)
      .ToLine();
}

std::vector<io::Histogram> StatisticsHistograms(const MeshStatistics& s) {
  const double bound = LeastAngle(s.rho);
  const auto mark = [&](double angle) {
    return io::Histogram::Mark{angle, absl::StrFormat("rho %.4g: %.1f", s.rho, angle)};
  };
  const auto histogram = [](const char* title, double hi, double tick, const auto& counts,
                            std::vector<io::Histogram::Mark> marks) {
    io::Histogram h;
    h.title = title;
    h.unit = "degrees";
    h.hi = hi;
    h.tick = tick;
    h.counts = ToVector(counts);
    h.marks = std::move(marks);
    return h;
  };
  return {histogram("Least angle of each triangle", 60, 5, s.least_angles, {mark(bound)}),
          histogram("All angles", 180, 10, s.angles, {mark(bound), mark(180 - 2 * bound)})};
}

}  // namespace dynmesh::cli
