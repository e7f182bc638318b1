#include <algorithm>
#include <set>

#include "core/coplanar/merge_coplanar.h"
#include "core/io/space/space_input.h"
#include "core/io/space/surface_files.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

std::string CheckOrder(const io::FileFeatures& input) {
  if (input.lines.size() != input.features.size()) return "counts disagree";
  for (std::size_t i = 0; i < input.features.size(); ++i) {
    const Feature& f = input.features[i];
    if (f.id != i + 1) return "ids are not in file order";
    if (input.Where(f.id).empty()) return "a feature without a place";
    const FeatureKind kind = i < input.point_count                         ? FeatureKind::kPoint
                             : i < input.point_count + input.segment_count ? FeatureKind::kSegment
                                                                           : FeatureKind::kPolygon;
    if (f.kind != kind) return "points, segments and polygons are not in this order";
  }
  return "";
}

// Segments of two points that are there, polygons of rings of three and more.
std::string CheckNames(const std::vector<Feature>& features) {
  std::set<FeatureId> points;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) points.insert(f.id);
  }
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kSegment) {
      if (f.ends[0] == f.ends[1]) return "a segment of one point";
      if (!points.contains(f.ends[0]) || !points.contains(f.ends[1])) return "an end is no point";
    }
    if (f.kind == FeatureKind::kPolygon && f.rings.empty()) return "a polygon without rings";
    for (const std::vector<FeatureId>& ring : f.rings) {
      const std::set<FeatureId> corners(ring.begin(), ring.end());
      if (corners.size() < 3 || corners.size() != ring.size()) return "a ring that is none";
      if (!std::includes(points.begin(), points.end(), corners.begin(), corners.end())) {
        return "a corner is no point";
      }
    }
  }
  return "";
}

std::string CheckMerge(const std::vector<Feature>& features, double tolerance) {
  const auto merged = coplanar::MergeCoplanar(features, tolerance);
  if (!merged.ok()) return merged.status().message().empty() ? "an error without a message" : "";
  if (std::string problem = CheckNames(*merged); !problem.empty()) return problem;
  auto backwards = coplanar::MergeCoplanar({features.rbegin(), features.rend()}, tolerance);
  if (!backwards.ok()) return "refused the other way round";
  const auto by_id = [](const Feature& a, const Feature& b) { return a.id < b.id; };
  std::sort(backwards->begin(), backwards->end(), by_id);
  return *backwards == *merged ? "" : "joined faces depend on their order";
}

std::string Check(const absl::StatusOr<io::FileFeatures>& input) {
  if (!input.ok()) return input.status().message().empty() ? "an error without a message" : "";
  if (std::string problem = CheckOrder(*input); !problem.empty()) return problem;
  if (std::string problem = CheckNames(input->features); !problem.empty()) return problem;
  for (const double tolerance : {0.0, 0.25}) {
    if (std::string problem = CheckMerge(input->features, tolerance); !problem.empty()) {
      return problem;
    }
  }
  return "";
}

}  // namespace

std::string FuzzSpaceInput(std::string_view bytes) {
  const std::vector<std::string_view> files = SplitFiles(bytes);
  const auto open_nodes = [&]() -> absl::StatusOr<io::TextReader> {
    if (files.size() < 2) return absl::NotFoundError("beside.node: no such file");
    return io::TextReader("beside.node", std::string(files[1]));
  };
  const auto first = [&] { return io::TextReader("fuzz", std::string(files[0])); };
  const auto whole = [&] { return io::TextReader("fuzz", std::string(bytes)); };
  for (const auto& input :
       {io::ParseSpacePolyText(first(), open_nodes), io::ParseSmeshText(first(), open_nodes),
        io::ParseSpaceNodeText(whole()), io::ParseOffText(whole()), io::ParseStlText(whole()),
        io::ParseObjText(whole()), io::ParsePlyText(whole())}) {
    if (std::string problem = Check(input); !problem.empty()) return problem;
  }
  return "";
}

}  // namespace dynmesh::fuzz
