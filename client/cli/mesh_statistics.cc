#include "client/cli/mesh_statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cli/json.h"
#include "client/cli/percentile.h"
#include "client/cli/words.h"

namespace dynmesh::cli {
namespace {

// Rounding may put the least angle of an equilateral triangle above 60.
void Count(double angle, std::vector<std::uint64_t>& counts) {
  const auto degree = static_cast<std::size_t>(std::max(angle, 0.0));
  ++counts[std::min(degree, counts.size() - 1)];
}

double SizeOf(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t) {
  const auto& a = mesh.vertices[t[0]];
  const auto& b = mesh.vertices[t[1]];
  const auto& c = mesh.vertices[t[2]];
  return ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2;
}

double SizeOf(const io::IndexedMesh& mesh, const io::IndexedMesh::Tetrahedron& t) {
  const auto a = mesh.vertices[t[0]].position();
  double to[3][3];
  for (std::size_t i = 0; i < 3; ++i) {
    const auto p = mesh.vertices[t[i + 1]].position();
    for (std::size_t k = 0; k < 3; ++k) to[i][k] = p[k] - a[k];
  }
  double volume = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
    volume += to[0][k] * (to[1][l] * to[2][m] - to[1][m] * to[2][l]);
  }
  return volume / 6;
}

std::vector<RegionStatistics> CountRegions(const io::IndexedMesh& mesh) {
  std::vector<RegionStatistics> regions(mesh.regions.count() + 1);
  for (std::size_t k = 1; k < regions.size(); ++k) {
    regions[k].polygons = mesh.regions.polygons[k - 1];
  }
  std::size_t i = 0;
  io::ForEachSimplex(mesh, [&](const auto& corners) {
    RegionStatistics& region = regions[mesh.regions.Of(i++)];
    ++region.simplices;
    region.size += SizeOf(mesh, corners);
  });
  return regions;
}

// `quality` is of a triangle or a tetrahedron.
template <class Quality>
void CountAngles(const Quality& quality, MeshStatistics& s, std::vector<double>& least) {
  Count(quality.min_angle_deg, s.least_angles);
  for (const double angle : quality.angles_deg) Count(angle, s.angles);
  least.push_back(quality.min_angle_deg);
}

const char* SizeWord(int dimension) { return dimension == 3 ? "volume" : "area"; }

std::string BoundsText(const MeshStatistics& s) {
  if (s.dimension == 3) {
    return absl::StrFormat(
               "slivers            %.3g %% of the tetrahedra below 5 degrees, %.3g %% below 10\n",
               100 * s.quality.share_below_5_deg, 100 * s.quality.share_below_10_deg) +
           BelowDihedralText(s.quality.below_dihedral, s.quality.exempt_dihedral, s.min_dihedral);
  }
  return absl::StrFormat("rho allows         %.2f to %.2f degrees\n", LeastAngle(s.rho),
                         180 - 2 * LeastAngle(s.rho));
}

std::vector<WorstDihedral> NameWorst(const io::IndexedMesh& mesh, const QualityReport& quality) {
  std::vector<WorstDihedral> worst;
  for (const WorstTetrahedron& t : quality.worst_dihedral) {
    WorstDihedral& named = worst.emplace_back();
    named.angle_deg = t.angle_deg;
    named.at = t.centroid;
    const io::IndexedMesh::Tetrahedron& corners = mesh.tetrahedra[t.index];
    for (std::size_t k = 0; k < 4; ++k) named.vertices[k] = std::uint64_t{corners[k]} + 1;
  }
  return worst;
}

std::string WorstText(const MeshStatistics& s) {
  if (s.worst_dihedral.empty()) return "";
  std::string text = absl::StrFormat("\n%12s  %-42s  %s\n", "least angle", "at", "vertices");
  for (const WorstDihedral& t : s.worst_dihedral) {
    const auto& [x, y, z] = t.at;
    const auto& [a, b, c, d] = t.vertices;
    absl::StrAppendFormat(&text, "%12.4f  %-42s  %d %d %d %d\n", t.angle_deg,
                          absl::StrFormat("%.6g %.6g %.6g", x, y, z), a, b, c, d);
  }
  return text;
}

std::vector<JsonObject> WorstJson(const MeshStatistics& s) {
  std::vector<JsonObject> worst;
  for (const WorstDihedral& t : s.worst_dihedral) {
    worst.push_back(JsonObject()
                        .Add("angle_deg", t.angle_deg)
                        .AddNumbers("at", {t.at.begin(), t.at.end()})
                        .AddCounts("vertices", {t.vertices.begin(), t.vertices.end()}));
  }
  return worst;
}

}  // namespace

double LeastAngle(double rho) { return std::asin(1 / (2 * rho)) * (180 / std::numbers::pi); }

MeshStatistics ComputeStatistics(const io::IndexedMesh& mesh, double rho, double min_dihedral) {
  MeshStatistics s;
  s.rho = rho;
  s.vertices = mesh.vertices.size();
  s.dimension = mesh.dimension;
  s.least_angles.resize(mesh.dimension == 3 ? 75 : 60);  // at most 70.53 degrees in 3D, 60 in 2D
  s.angles.resize(180);
  s.simplices = mesh.simplex_count();
  s.subsegments = mesh.subsegment_count();
  s.subfacets = mesh.subfacet_count();
  MeshOptions options;
  options.dimension = mesh.dimension;
  options.quality = rho;
  options.min_dihedral = s.min_dihedral = min_dihedral;
  s.quality = MeasureQuality(io::ToMesh(mesh), options);
  s.worst_dihedral = NameWorst(mesh, s.quality);
  std::vector<double> least;
  least.reserve(s.simplices);
  for (std::size_t i = 0; i < s.simplices; ++i) {
    if (mesh.dimension == 3) {
      CountAngles(io::MeasureTetrahedron(mesh, i), s, least);
    } else {
      CountAngles(io::MeasureTriangle(mesh, i), s, least);
    }
  }
  s.regions = CountRegions(mesh);
  if (!least.empty()) s.median_min_angle_deg = Percentile(std::move(least), 0.5);
  return s;
}

std::string StatisticsText(const MeshStatistics& s) {
  const bool in_space = s.dimension == 3;
  std::string text = absl::StrFormat(
      "vertices           %d\n"
      "%-17s  %d\n"
      "subsegments        %d\n"
      "%s"
      "%-17s  %.2f to %.2f degrees\n"
      "least angle        %.2f degrees in the median %s\n"
      "worst radius-edge  %.6g\n"
      "over rho           %d of rho %.6g (%d exempt, %d of them by the termination guard)\n"
      "%s",
      s.vertices, SimplicesWord(s.dimension), s.simplices, s.subsegments,
      in_space ? absl::StrFormat("subfacets          %d\n", s.subfacets) : "",
      AnglesWord(s.dimension), s.quality.min_angle_deg, s.quality.max_angle_deg,
      s.median_min_angle_deg, in_space ? "tetrahedron" : "triangle", s.quality.worst_radius_edge,
      s.quality.over_rho, s.rho, s.quality.exempt, s.quality.exempt_by_guard, BoundsText(s));
  if (s.regions.size() > 1) {
    absl::StrAppendFormat(&text, "\n%12s  %12s  %s\n", SimplicesWord(s.dimension),
                          SizeWord(s.dimension), "inside");
    for (const RegionStatistics& region : s.regions) {
      std::string polygons = io::FormatPolygons(region.polygons);
      if (region.polygons.size() == 1 && s.names.contains(region.polygons[0])) {
        polygons += " " + s.names.at(region.polygons[0]);
      }
      absl::StrAppendFormat(&text, "%12d  %12.6g  %s\n", region.simplices, region.size,
                            polygons.empty() ? "no polygon" : polygons);
    }
  }
  text += WorstText(s);
  if (s.has_histogram) {
    absl::StrAppendFormat(&text, "\n%7s  %12s  %12s\n", "degrees", "least angles", "all angles");
  }
  for (std::size_t i = 0; i < s.angles.size() && s.has_histogram; ++i) {
    const std::uint64_t least = i < s.least_angles.size() ? s.least_angles[i] : 0;
    if (s.angles[i] == 0 && least == 0) continue;
    absl::StrAppendFormat(&text, "%3d-%-3d  %12d  %12d\n", i, i + 1, least, s.angles[i]);
  }
  if (s.conformity) text += ConformityText(*s.conformity);
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
                          .Add(SizeWord(s.dimension), region.size));
  }
  JsonObject object;
  object.Add("vertices", s.vertices)
      .Add("simplices", s.simplices)
      .Add("subsegments", s.subsegments)
      .Add("subfacets", s.subfacets)
      .Add("dimension", s.dimension)
      .Add("rho", s.rho)
      .Add("worst_radius_edge", s.quality.worst_radius_edge)
      .Add("min_angle_deg", s.quality.min_angle_deg)
      .Add("max_angle_deg", s.quality.max_angle_deg)
      .Add("median_min_angle_deg", s.median_min_angle_deg)
      .Add("over_rho", s.quality.over_rho)
      .Add("exempt", s.quality.exempt)
      .Add("exempt_by_guard", s.quality.exempt_by_guard);
  if (s.dimension == 3) {
    object.Add("share_below_5_deg", s.quality.share_below_5_deg)
        .Add("share_below_10_deg", s.quality.share_below_10_deg);
    if (s.min_dihedral > 0) {
      object.Add("below_dihedral", s.quality.below_dihedral)
          .Add("exempt_dihedral", s.quality.exempt_dihedral);
    }
    object.AddObjects("worst_dihedral", WorstJson(s));
  } else {
    object.Add("rho_min_angle_deg", LeastAngle(s.rho))
        .Add("rho_max_angle_deg", 180 - 2 * LeastAngle(s.rho));
  }
  if (s.conformity) object.AddObject("lfs_over_lms", ConformityJson(*s.conformity));
  if (!s.names.empty()) {
    JsonObject names;
    for (const auto& [id, name] : s.names) names.AddText(std::to_string(id), name);
    object.AddObject("names", names);
  }
  return object.Add("histogram_step_deg", 1)
      .AddCounts("least_angle_histogram", s.least_angles)
      .AddCounts("angle_histogram", s.angles)
      .AddObjects("regions", regions)
      .ToLine();
}

std::vector<io::Histogram> StatisticsHistograms(const MeshStatistics& s) {
  const double bound = LeastAngle(s.rho);
  const auto mark = [&](double angle) {
    return io::Histogram::Mark{angle, absl::StrFormat("rho %.4g: %.1f", s.rho, angle)};
  };
  const auto histogram = [](const char* title, double tick,
                            const std::vector<std::uint64_t>& counts,
                            std::vector<io::Histogram::Mark> marks) {
    io::Histogram h;
    h.title = title;
    h.unit = "degrees";
    h.hi = static_cast<double>(counts.size());
    h.tick = tick;
    h.counts = counts;
    h.marks = std::move(marks);
    return h;
  };
  if (s.dimension == 3) {
    return {histogram("Least dihedral angle of each tetrahedron", 5, s.least_angles, {}),
            histogram("All dihedral angles", 10, s.angles, {})};
  }
  return {histogram("Least angle of each triangle", 5, s.least_angles, {mark(bound)}),
          histogram("All angles", 10, s.angles, {mark(bound), mark(180 - 2 * bound)})};
}

}  // namespace dynmesh::cli
