// Figures of a mesh file: counts, quality, and the distribution of its angles. Pure functions.
#ifndef DYNMESH_CLIENT_CLI_MESH_STATISTICS_H_
#define DYNMESH_CLIENT_CLI_MESH_STATISTICS_H_

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/size_conformity.h"
#include "core/io/meshes/indexed_mesh.h"
#include "core/io/pictures/histogram_svg.h"
#include "dynmesh/quality.h"

namespace dynmesh::cli {

// The part of the mesh in one set of polygons, or in none.
struct RegionStatistics {
  std::vector<FeatureId> polygons;
  std::uint64_t simplices = 0;
  double size = 0;  // area, in 3D volume
};

// One of the tetrahedra with the least dihedral angles.
struct WorstDihedral {
  double angle_deg = 0;
  std::array<double, 3> at = {0, 0, 0};                  // its centroid
  std::array<std::uint64_t, 4> vertices = {0, 0, 0, 0};  // as the files number them, from 1
};

struct MeshStatistics {
  int dimension = 2;
  double rho = kDefaultQuality2D;
  std::uint64_t vertices = 0;
  std::uint64_t simplices = 0;
  std::uint64_t subsegments = 0;
  std::uint64_t subfacets = 0;  // in 3D
  QualityReport quality;
  double min_dihedral = 0;                    // the bound for `quality`; 0: no bound is known
  std::vector<WorstDihedral> worst_dihedral;  // in 3D, those of `quality`, the least first
  double median_min_angle_deg = 0;            // of the simplices' least angles; 0 without simplices
  // Histogram by degrees: [i, i + 1), the last one closed. In 3D of dihedral angles.
  std::vector<std::uint64_t> least_angles;   // one per simplex; 60 entries, in 3D 75
  std::vector<std::uint64_t> angles;         // three per triangle, six per tetrahedron; 180 entries
  std::vector<RegionStatistics> regions;     // by number; no polygon first
  std::map<FeatureId, std::string> names;    // of features
  bool has_histogram = false;                // in the text; JSON has it always
  std::optional<SizeConformity> conformity;  // where the input is known
};

// The least angle, in degrees, that a triangle with radius-edge ratio <= rho can have.
double LeastAngle(double rho);

// `min_dihedral` in degrees is for 3D; 0: no bound is known. O(size).
MeshStatistics ComputeStatistics(const io::IndexedMesh& mesh, double rho, double min_dihedral = 0);

// Text for people and for programs; both have all figures. JSON: one object on a line.
std::string StatisticsText(const MeshStatistics& statistics);
std::string StatisticsJson(const MeshStatistics& statistics);

// Least angles above, all angles below; in 2D with the bounds from rho.
std::vector<io::Histogram> StatisticsHistograms(const MeshStatistics& statistics);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_MESH_STATISTICS_H_
