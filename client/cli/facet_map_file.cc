#include "client/cli/facet_map_file.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <system_error>
#include <vector>

#include "client/preparation/facet_map.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"

namespace dynmesh::cli {
namespace {

void WriteList(const std::vector<std::size_t>& indices, io::FileWriter& out) {
  out << '[';
  for (std::size_t i = 0; i < indices.size(); ++i) out << (i == 0 ? "" : ", ") << indices[i];
  out << ']';
}

}  // namespace

absl::Status WriteFacetMap(const std::string& surface, const Input& input,
                           const std::string& path) {
  std::error_code error;  // of files that do not exist: they are not the same
  if (std::filesystem::equivalent(path, surface, error)) {
    return absl::InvalidArgumentError(text::Concat("--map: ", path, " is the input"));
  }
  const absl::StatusOr<std::vector<FeatureId>> found = preparation::PolygonsOfFacets(
      surface, input, input.preparation ? input.preparation->within : 0);
  if (!found.ok()) {
    return absl::Status(found.status().code(),
                        text::Concat("--map: ", text::View(found.status().message())));
  }
  const std::vector<FeatureId>& polygons = *found;
  std::map<FeatureId, std::vector<std::size_t>> facets_of;
  for (std::size_t i = 0; i < polygons.size(); ++i) facets_of[polygons[i]].push_back(i);
  io::FileWriter out(path);
  out << "{\"facets\": " << polygons.size() << ", \"of_none\": ";
  WriteList(facets_of[kNoFeature], out);
  out << ", \"polygons\": [";
  bool is_first = true;
  for (const auto& [id, facets] : facets_of) {
    if (id == kNoFeature) continue;
    out << (is_first ? "\n" : ",\n") << "{\"id\": \"" << id << "\", \"facets\": ";
    WriteList(facets, out);
    out << '}';
    is_first = false;
  }
  out << "\n]}\n";
  return out.Close();
}

}  // namespace dynmesh::cli
