#include "core/io/plane/planar_output.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include "absl/container/flat_hash_map.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/script/edit_script.h"

namespace dynmesh::io {

namespace {

void WriteSeeds(const std::vector<SeedRow>& seeds, FileWriter& out) {
  out << seeds.size() << '\n';
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    out << i + 1 << ' ' << seeds[i].position[0] << ' ' << seeds[i].position[1];
    for (const double value : seeds[i].more) out << ' ' << value;
    out << '\n';
  }
}

}  // namespace

absl::Status WritePolyFile(const std::string& path, const std::vector<Feature>& features,
                           const std::vector<SeedRow>& holes, const std::vector<SeedRow>& regions,
                           const FeatureLabels& labels) {
  absl::flat_hash_map<FeatureId, std::size_t> number;
  for (const Feature& f : features) {
    if (IsPoint(f)) number.emplace(f.id, number.size() + 1);
  }
  std::vector<std::array<std::size_t, 2>> segments;
  std::vector<std::int64_t> markers;  // of segments
  for (const Feature& f : features) {
    if (!Is<ASegment>(f, Not<APoint, APolygon, ASize>)) continue;
    std::array<std::size_t, 2> ends{};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto it = number.find(f.ends[i]);
      if (it == number.end()) {
        return absl::InvalidArgumentError(
            text::Concat("segment ", f.id, " ends at ", f.ends[i], ", which is no point; add it"));
      }
      ends[i] = it->second;
    }
    segments.push_back(ends);
    markers.push_back(labels.MarkerOf(f.id));
  }
  FileWriter out(path);
  const bool has_markers = !labels.markers.empty();
  out << number.size() << " 2 " << labels.attributes << (has_markers ? " 1\n" : " 0\n");
  std::size_t n = 0;
  for (const Feature& f : features) {
    if (!IsPoint(f)) continue;
    out << ++n << ' ' << f.position[0] << ' ' << f.position[1];
    for (std::size_t k = 0; k < labels.attributes; ++k) {
      const std::size_t at = (f.id - 1) * labels.attributes + k;
      out << ' ' << (at < labels.values.size() ? labels.values[at] : 0.0);
    }
    if (has_markers) out << ' ' << labels.MarkerOf(f.id);
    out << '\n';
  }
  out << segments.size() << (has_markers ? " 1\n" : " 0\n");
  for (std::size_t i = 0; i < segments.size(); ++i) {
    out << i + 1 << ' ' << segments[i][0] << ' ' << segments[i][1];
    if (has_markers) out << ' ' << markers[i];
    out << '\n';
  }
  WriteSeeds(holes, out);
  if (!regions.empty()) WriteSeeds(regions, out);
  return out.Close();
}

absl::Status WriteFeatureScript(const std::string& path, const MeshOptions& options,
                                const std::vector<Feature>& features, const FeatureLabels& labels) {
  FileWriter out(path);
  out << FormatMeshLine(options) << '\n';
  for (const Feature& f : features) out << FormatEdit(Edit::Add(f), options.dimension) << '\n';
  out << "commit\n";
  for (const Feature& f : features) {
    out << FormatLabel(f.id, {labels.MarkerOf(f.id), labels.NameOf(f.id)});
  }
  return out.Close();
}

}  // namespace dynmesh::io
