#include "core/io/meshes/vtu_writer.h"

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/common/vtu_array.h"
#include "dynmesh/quality.h"

namespace dynmesh::io {
namespace {

// The polygons of each region's number.
void WriteRegionTable(const RegionNumbers& regions, FileWriter& out) {
  if (regions.count() == 0) return;
  std::vector<std::int64_t> polygons;
  std::vector<std::int64_t> ends;
  for (const std::vector<FeatureId>& row : regions.polygons) {
    for (const FeatureId id : row) polygons.push_back(static_cast<std::int64_t>(id));
    ends.push_back(static_cast<std::int64_t>(polygons.size()));
  }
  const auto write = [&out](std::string_view name, const std::vector<std::int64_t>& values) {
    const std::string shape = text::Concat("NumberOfTuples=\"", values.size(), "\"");
    WriteShapedArray("Int64", name, shape, values, out);
  };
  out << "    <FieldData>\n";
  write("region_polygons", polygons);
  write("region_ends", ends);
  out << "    </FieldData>\n";
}

void WritePoints(const IndexedMesh& mesh, FileWriter& out) {
  std::vector<double> positions;
  positions.reserve(3 * mesh.vertices.size());
  for (const auto& v : mesh.vertices) positions.insert(positions.end(), {v.x, v.y, v.z});
  out << "      <Points>\n";
  WriteArray("Float64", "Points", 3, positions, out);
  out << "      </Points>\n";
}

bool IsSubfacet(const IndexedMesh::Face& f) {
  return f.owner != kNoFeature && f.owner != kBoxFeature;
}

// Simplices, then subfacets.
void WriteCells(const IndexedMesh& mesh, FileWriter& out) {
  constexpr std::uint8_t kVtkTriangle = 5;
  constexpr std::uint8_t kVtkTetra = 10;
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> offsets;
  std::vector<std::uint8_t> types;
  const std::size_t n = mesh.simplex_count() + mesh.subfacet_count();
  connectivity.reserve((static_cast<std::size_t>(mesh.dimension) + 1) * n);
  offsets.reserve(n);
  const auto add = [&](const auto& corners) {
    connectivity.insert(connectivity.end(), corners.begin(), corners.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(corners.size() == 3 ? kVtkTriangle : kVtkTetra);
  };
  ForEachSimplex(mesh, add);
  for (const auto& f : mesh.faces) {
    if (IsSubfacet(f)) add(f.corners);
  }
  out << "      <Cells>\n";
  WriteArray("Int64", "connectivity", 1, connectivity, out);
  WriteArray("Int64", "offsets", 1, offsets, out);
  WriteArray("UInt8", "types", 1, types, out);
  out << "      </Cells>\n";
}

void WritePointData(const IndexedMesh& mesh, FileWriter& out) {
  std::vector<std::uint8_t> dimensions;
  std::vector<std::int64_t> owners;
  for (const auto& v : mesh.vertices) {
    dimensions.push_back(static_cast<std::uint8_t>(v.containing_dimension));
    owners.push_back(static_cast<std::int64_t>(v.owner));
  }
  out << "      <PointData Scalars=\"containing_dimension\">\n";
  WriteArray("UInt8", "containing_dimension", 1, dimensions, out);
  WriteArray("Int64", "owner", 1, owners, out);
  out << "      </PointData>\n";
}

// The numbers of the array `exempt`. kOverRho has none: the ratio shows it.
std::uint8_t ExemptNumber(SimplexVerdict verdict) {
  switch (verdict) {
    case SimplexVerdict::kSmallInputAngle:
      return 1;
    case SimplexVerdict::kTerminationGuard:
      return 2;
    case SimplexVerdict::kBelowDihedral:
      return 3;
    case SimplexVerdict::kGood:
    case SimplexVerdict::kOverRho:
      return 0;
  }
  return 0;
}

void WriteCellData(const IndexedMesh& mesh, double rho, double min_dihedral, FileWriter& out) {
  std::vector<double> ratios;
  std::vector<double> angles;
  std::vector<std::uint8_t> exempt;
  for (std::size_t i = 0; i < mesh.simplex_count(); ++i) {
    const SimplexMeasures q = MeasureSimplex(mesh, i);
    ratios.push_back(q.radius_edge);
    angles.push_back(q.min_angle_deg);
  }
  for (const SimplexVerdict verdict : JudgeSimplices(mesh, rho, min_dihedral)) {
    exempt.push_back(ExemptNumber(verdict));
  }
  std::vector<std::uint32_t> regions = mesh.regions.numbers;
  std::vector<std::int64_t> owners(mesh.simplex_count(), 0);
  for (const auto& f : mesh.faces) {
    if (IsSubfacet(f)) owners.push_back(static_cast<std::int64_t>(f.owner));
  }
  // Values that do not apply to subfacets.
  ratios.resize(owners.size(), std::numeric_limits<double>::quiet_NaN());
  angles.resize(owners.size(), std::numeric_limits<double>::quiet_NaN());
  exempt.resize(owners.size(), 0);
  regions.resize(owners.size(), 0);
  out << "      <CellData Scalars=\"min_angle\">\n";
  WriteArray("Float64", "quality", 1, ratios, out);
  WriteArray("Float64", "min_angle", 1, angles, out);
  WriteArray("UInt8", "exempt", 1, exempt, out);
  WriteArray("Float64", "radius_edge", 1, ratios, out);
  WriteArray("Float64", "min_angle_deg", 1, angles, out);
  if (mesh.regions.count() != 0) {
    WriteArray("UInt32", "region", 1, regions, out);
  }
  if (mesh.dimension == 3) {
    WriteArray("Float64", "min_dihedral", 1, angles, out);
    WriteArray("Int64", "owner", 1, owners, out);
  }
  out << "      </CellData>\n";
}

}  // namespace

absl::Status WriteVtu(const IndexedMesh& mesh, double rho, const std::string& path,
                      double min_dihedral) {
  FileWriter out(path);
  out << kVtuBegin;
  WriteRegionTable(mesh.regions, out);
  out << "    <Piece NumberOfPoints=\"" << mesh.vertices.size() << "\" NumberOfCells=\""
      << mesh.simplex_count() + mesh.subfacet_count() << "\">\n";
  WritePoints(mesh, out);
  WriteCells(mesh, out);
  WritePointData(mesh, out);
  WriteCellData(mesh, rho, min_dihedral, out);
  out << "    </Piece>\n" << kVtuEnd;
  return out.Close();
}

}  // namespace dynmesh::io
