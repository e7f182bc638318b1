// Figures of a mesh file: counts, quality, and how its angles are distributed. Pure functions.
#ifndef DYNMESH_CLIENT_CLI_MESH_STATISTICS_H_
#define DYNMESH_CLIENT_CLI_MESH_STATISTICS_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/io/histogram_svg.h"
#include "core/io/indexed_mesh.h"
#include "dynmesh/quality.h"

namespace dynmesh::cli {

// What lies in one set of polygons, or in none.
struct RegionStatistics {
  std::vector<FeatureId> polygons;
  std::uint64_t simplices = 0;
  double area = 0;
};

struct MeshStatistics {
  double rho = kDefaultQuality2D;
  std::uint64_t vertices = 0;
  std::uint64_t simplices = 0;
  std::uint64_t subsegments = 0;
  QualityReport quality;
  double median_min_angle_deg = 0;  // of the triangles' least angles; 0 if there is none
  // By degrees: [i, i + 1), the last one with its end.
  std::array<std::uint64_t, 60> least_angles = {};  // one a triangle
  std::array<std::uint64_t, 180> angles = {};       // three a triangle
  std::vector<RegionStatistics> regions;            // by number, that of no polygon first
};

// The least angle that a triangle within rho may have, in degrees.
double LeastAngle(double rho);

// O(size).
MeshStatistics ComputeStatistics(const io::IndexedMesh& mesh, double rho);

// For people and for programs; both have all the numbers. JSON: one object on a line.
std::string StatisticsText(const MeshStatistics& statistics);
std::string StatisticsJson(const MeshStatistics& statistics);

// Least angles above, all angles below, rho's bounds marked in both.
std::vector<io::Histogram> StatisticsHistograms(const MeshStatistics& statistics);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_MESH_STATISTICS_H_
