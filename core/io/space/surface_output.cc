#include "core/io/space/surface_output.h"

#include <cstddef>
#include <cstdint>

#include "absl/container/flat_hash_map.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"

namespace dynmesh::io {
namespace {

using text::Concat;

// A polygon, or a segment: of two corners.
struct Face {
  FeatureId id = kNoFeature;
  std::vector<std::size_t> corners;  // indices of points
};

struct Surface {
  std::vector<const Feature*> points;
  std::vector<Face> faces;  // segments first
  std::size_t segments = 0;
};

absl::StatusOr<Surface> SurfaceOf(const std::vector<Feature>& features) {
  Surface surface;
  absl::flat_hash_map<FeatureId, std::size_t> index;
  for (const Feature& f : features) {
    if (!IsPoint(f)) continue;
    index.emplace(f.id, surface.points.size());
    surface.points.push_back(&f);
  }
  const auto add = [&](const Feature& f, const auto& corners) -> absl::Status {
    Face& face = surface.faces.emplace_back();
    face.id = f.id;
    for (const FeatureId corner : corners) {
      const auto it = index.find(corner);
      if (it == index.end()) {
        return absl::InvalidArgumentError(
            Concat("feature ", f.id, " has the corner ", corner, ", which is no point; add it"));
      }
      face.corners.push_back(it->second);
    }
    return absl::OkStatus();
  };
  for (const Feature& f : features) {
    if (!Is<ASegment>(f, Not<APoint, APolygon, ASize>)) continue;
    if (auto s = add(f, f.ends); !s.ok()) return s;
  }
  surface.segments = surface.faces.size();
  for (const Feature& f : features) {
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    if (f.rings.size() != 1) {
      return absl::InvalidArgumentError(Concat("polygon ", f.id, " has ", f.rings.size(),
                                               " rings, and this format a place for one; write a "
                                               ".dynmesh"));
    }
    if (auto s = add(f, f.rings.front()); !s.ok()) return s;
  }
  return surface;
}

void WriteSeeds(const std::vector<SeedRow>& seeds, FileWriter& out) {
  out << seeds.size() << '\n';
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    out << i + 1;
    for (const double x : seeds[i].position) out << ' ' << x;
    for (const double value : seeds[i].more) out << ' ' << value;
    out << '\n';
  }
}

absl::Status WriteTetGen(const std::string& path, bool is_smesh,
                         const std::vector<Feature>& features, const std::vector<SeedRow>& holes,
                         const std::vector<SeedRow>& regions, const FeatureLabels& labels) {
  const absl::StatusOr<Surface> surface = SurfaceOf(features);
  if (!surface.ok()) return surface.status();
  FileWriter out(path);
  const bool has_markers = !labels.markers.empty();
  const char* const flag = has_markers ? " 1\n" : " 0\n";
  out << surface->points.size() << " 3 " << labels.attributes << flag;
  for (std::size_t i = 0; i < surface->points.size(); ++i) {
    const Feature& f = *surface->points[i];
    out << i + 1;
    for (const double x : f.position) out << ' ' << x;
    for (std::size_t k = 0; k < labels.attributes; ++k) {
      const std::size_t at = (f.id - 1) * labels.attributes + k;
      out << ' ' << (at < labels.values.size() ? labels.values[at] : 0.0);
    }
    if (has_markers) out << ' ' << labels.MarkerOf(f.id);
    out << '\n';
  }
  out << surface->faces.size() << flag;
  for (const Face& face : surface->faces) {
    const auto write_marker = [&] {
      if (has_markers) out << ' ' << labels.MarkerOf(face.id);
    };
    if (!is_smesh) {
      out << "1 0";
      write_marker();
      out << '\n';
    }
    out << face.corners.size();
    for (const std::size_t corner : face.corners) out << ' ' << corner + 1;
    if (is_smesh) write_marker();
    out << '\n';
  }
  WriteSeeds(holes, out);
  if (!regions.empty()) WriteSeeds(regions, out);
  return out.Close();
}

}  // namespace

absl::Status WriteSpacePolyFile(const std::string& path, const std::vector<Feature>& features,
                                const std::vector<SeedRow>& holes,
                                const std::vector<SeedRow>& regions, const FeatureLabels& labels) {
  return WriteTetGen(path, false, features, holes, regions, labels);
}

absl::Status WriteSmeshFile(const std::string& path, const std::vector<Feature>& features,
                            const std::vector<SeedRow>& holes, const std::vector<SeedRow>& regions,
                            const FeatureLabels& labels) {
  return WriteTetGen(path, true, features, holes, regions, labels);
}

absl::Status WriteOffFile(const std::string& path, const std::vector<Feature>& features) {
  const absl::StatusOr<Surface> surface = SurfaceOf(features);
  if (!surface.ok()) return surface.status();
  FileWriter out(path);
  out << "OFF\n"
      << surface->points.size() << ' ' << surface->faces.size() - surface->segments << " 0\n";
  for (const Feature* f : surface->points) {
    out << f->position[0] << ' ' << f->position[1] << ' ' << f->position[2] << '\n';
  }
  for (std::size_t i = surface->segments; i < surface->faces.size(); ++i) {
    const Face& face = surface->faces[i];
    out << face.corners.size();
    for (const std::size_t corner : face.corners) out << ' ' << corner;
    out << '\n';
  }
  return out.Close();
}

}  // namespace dynmesh::io
