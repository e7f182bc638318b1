#include "core/io/meshes/vtu_writer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/common/parallel.h"
#include "core/io/common/vtu_array.h"
#include "core/io/meshes/region_labels.h"
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
  write("region_polygons", polygons);
  write("region_ends", ends);
}

void WritePoints(const IndexedMesh& mesh, int threads, FileWriter& out) {
  std::vector<double> positions;
  positions.reserve(3 * mesh.vertices.size());
  for (const auto& v : mesh.vertices) positions.insert(positions.end(), {v.x, v.y, v.z});
  out << "      <Points>\n";
  WriteArray("Float64", "Points", 3, positions, out, threads);
  out << "      </Points>\n";
}

// As the value of an XML attribute.
std::string Escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&') {
      result += "&amp;";
    } else if (c == '<') {
      result += "&lt;";
    } else if (c == '"') {
      result += "&quot;";
    } else {
      result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return result;
}

// An array by each name, of the features that have it.
void WriteNames(const RowLabels& labels, FileWriter& out) {
  if (labels.features == nullptr) return;
  std::map<std::string, std::vector<std::int64_t>> features;
  for (const auto& [id, name] : labels.features->names) {
    features[name].push_back(static_cast<std::int64_t>(id));
  }
  for (const auto& [name, ids] : features) {
    const std::string shape = text::Concat("NumberOfTuples=\"", ids.size(), "\"");
    WriteShapedArray("Int64", Escaped(name), shape, ids, out);
  }
}

// Calls f(corners, owner, row) for each subsegment (in 3D subfacet) of a feature.
template <class F>
void ForEachConstraint(const IndexedMesh& mesh, F f) {
  const auto is_features = [](FeatureId owner) {
    return owner != kNoFeature && owner != kBoxFeature;
  };
  if (mesh.dimension == 2) {
    for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
      const IndexedMesh::Edge& e = mesh.edges[i];
      if (is_features(e.owner)) f(std::array{e.a, e.b}, e.owner, i);
    }
  } else {
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      const IndexedMesh::Face& face = mesh.faces[i];
      if (is_features(face.owner)) f(face.corners, face.owner, i);
    }
  }
}

std::size_t CountConstraints(const IndexedMesh& mesh) {
  std::size_t count = 0;
  ForEachConstraint(mesh, [&](const auto&, FeatureId, std::size_t) { ++count; });
  return count;
}

// Simplices, then subfacets.
void WriteCells(const IndexedMesh& mesh, int threads, FileWriter& out) {
  // By order and corners: line, triangle, tetrahedron.
  constexpr std::uint8_t kVtkOf[2][5] = {{0, 0, 3, 5, 10}, {0, 0, 21, 22, 24}};
  const std::vector<std::pair<std::size_t, std::size_t>> midpoints_of[] = {
      {}, {}, {{0, 1}}, {{0, 1}, {1, 2}, {2, 0}}, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> offsets;
  std::vector<std::uint8_t> types;
  const std::size_t n = mesh.simplex_count() + CountConstraints(mesh);
  connectivity.reserve((static_cast<std::size_t>(mesh.dimension) + 1) * n);
  offsets.reserve(n);
  types.reserve(n);
  const auto add = [&](const auto& corners) {
    connectivity.insert(connectivity.end(), corners.begin(), corners.end());
    if (mesh.order() == 2) {
      for (const auto& [j, k] : midpoints_of[corners.size()]) {
        connectivity.push_back(mesh.MidpointOf(corners[j], corners[k]));
      }
    }
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    types.push_back(kVtkOf[mesh.order() - 1][corners.size()]);
  };
  ForEachSimplex(mesh, add);
  ForEachConstraint(mesh, [&](const auto& corners, FeatureId, std::size_t) { add(corners); });
  out << "      <Cells>\n";
  WriteArray("Int64", "connectivity", 1, connectivity, out, threads);
  WriteArray("Int64", "offsets", 1, offsets, out, threads);
  WriteArray("UInt8", "types", 1, types, out, threads);
  out << "      </Cells>\n";
}

void WritePointData(const IndexedMesh& mesh, int threads, FileWriter& out) {
  std::vector<std::uint8_t> dimensions;
  std::vector<std::int64_t> owners;
  dimensions.reserve(mesh.vertices.size());
  owners.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) {
    dimensions.push_back(static_cast<std::uint8_t>(v.containing_dimension));
    owners.push_back(static_cast<std::int64_t>(v.owner));
  }
  out << "      <PointData Scalars=\"containing_dimension\">\n";
  WriteArray("UInt8", "containing_dimension", 1, dimensions, out, threads);
  WriteArray("Int64", "owner", 1, owners, out, threads);
  const RowLabels& labels = mesh.labels;
  if (!labels.vertex_markers.empty()) {
    WriteArray("Int64", "marker", 1, labels.vertex_markers, out);
  }
  if (labels.attributes != 0) {
    WriteArray("Float64", "attribute", static_cast<int>(labels.attributes), labels.vertex_values,
               out);
  }
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
    case SimplexVerdict::kUnsplit:
      return 4;
    case SimplexVerdict::kGood:
    case SimplexVerdict::kOverRho:
      return 0;
  }
  return 0;
}

// Is every simplex kGood for certain, with these ratios and least angles?
bool AreGood(const std::vector<double>& ratios, const std::vector<double>& angles, double rho,
             double min_dihedral) {
  // Many times what verdicts differ from measures by.
  constexpr double kRelative = 1e-6, kDegrees = 1e-3;
  const bool has_least = min_dihedral > 0;
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    if (!(ratios[i] < rho * (1 - kRelative))) return false;
    if (has_least && !(angles[i] > min_dihedral + kDegrees)) return false;
  }
  return true;
}

void WriteCellData(const IndexedMesh& mesh, double rho, double min_dihedral, int threads,
                   FileWriter& out) {
  const std::size_t n = mesh.simplex_count();
  std::vector<double> ratios(n), angles(n);
  constexpr std::size_t kRows = 8192;
  ForEachBlock((n + kRows - 1) / kRows, threads, [&](std::size_t block) {
    for (std::size_t i = block * kRows; i < std::min((block + 1) * kRows, n); ++i) {
      const SimplexMeasures q = MeasureSimplex(mesh, i);
      ratios[i] = q.radius_edge;
      angles[i] = q.min_angle_deg;
    }
  });
  std::vector<std::uint8_t> exempt;
  if (!AreGood(ratios, angles, rho, mesh.dimension == 3 ? min_dihedral : 0)) {
    exempt.reserve(n);
    for (const SimplexVerdict verdict : JudgeSimplices(mesh, rho, min_dihedral)) {
      exempt.push_back(ExemptNumber(verdict));
    }
  }
  std::vector<std::uint32_t> regions = mesh.regions.numbers;
  std::vector<std::int64_t> owners(n, 0);
  std::vector<std::int64_t> markers(n, 0);
  const std::vector<RegionLabel> labels = RegionLabelsOf(mesh);
  for (std::size_t i = 0; i < markers.size(); ++i) markers[i] = labels[mesh.regions.Of(i)].marker;
  std::vector<double> values = mesh.labels.simplex_values;
  const auto& row_markers =
      mesh.dimension == 2 ? mesh.labels.edge_markers : mesh.labels.face_markers;
  ForEachConstraint(mesh, [&](const auto&, FeatureId owner, std::size_t row) {
    owners.push_back(static_cast<std::int64_t>(owner));
    markers.push_back(row_markers.empty() ? 0 : row_markers[row]);
  });
  // Values that do not apply to subfacets.
  ratios.resize(owners.size(), std::numeric_limits<double>::quiet_NaN());
  angles.resize(owners.size(), std::numeric_limits<double>::quiet_NaN());
  exempt.resize(owners.size(), 0);
  regions.resize(owners.size(), 0);
  values.resize(owners.size(), 0);
  out << "      <CellData Scalars=\"min_angle\">\n";
  // Under a short name and under that of the library.
  const std::string of_ratios = CompressedArray(ratios, threads);
  const std::string of_angles = CompressedArray(angles, threads);
  WriteCompressedArray("Float64", "quality", "", of_ratios, out);
  WriteCompressedArray("Float64", "min_angle", "", of_angles, out);
  WriteArray("UInt8", "exempt", 1, exempt, out, threads);
  WriteCompressedArray("Float64", "radius_edge", "", of_ratios, out);
  WriteCompressedArray("Float64", "min_angle_deg", "", of_angles, out);
  if (mesh.regions.count() != 0) {
    WriteArray("UInt32", "region", 1, regions, out, threads);
  }
  if (mesh.dimension == 3) WriteCompressedArray("Float64", "min_dihedral", "", of_angles, out);
  WriteArray("Int64", "owner", 1, owners, out, threads);
  if (!row_markers.empty()) WriteArray("Int64", "marker", 1, markers, out, threads);
  if (!mesh.labels.simplex_values.empty()) {
    WriteArray("Float64", "attribute", 1, values, out, threads);
  }
  out << "      </CellData>\n";
}

}  // namespace

absl::Status WriteVtu(const IndexedMesh& mesh, double rho, const std::string& path,
                      double min_dihedral, int threads) {
  FileWriter out(path);
  out << kVtuBegin;
  const bool has_names = mesh.labels.features != nullptr && !mesh.labels.features->names.empty();
  if (mesh.regions.count() != 0 || has_names) {
    out << "    <FieldData>\n";
    WriteRegionTable(mesh.regions, out);
    WriteNames(mesh.labels, out);
    out << "    </FieldData>\n";
  }
  out << "    <Piece NumberOfPoints=\"" << mesh.vertices.size() << "\" NumberOfCells=\""
      << mesh.simplex_count() + CountConstraints(mesh) << "\">\n";
  WritePoints(mesh, threads, out);
  WriteCells(mesh, threads, out);
  WritePointData(mesh, threads, out);
  WriteCellData(mesh, rho, min_dihedral, threads, out);
  out << "    </Piece>\n" << kVtuEnd;
  return out.Close();
}

}  // namespace dynmesh::io
