#include "core/io/common/file_features.h"

#include <iterator>

#include "core/base/text.h"

namespace dynmesh::io {

std::string FileFeatures::Where(FeatureId id) const {
  if (id == kNoFeature || id > lines.size()) return "";
  const auto next = files_from.upper_bound(id);
  const std::string& file = next != files_from.begin() ? std::prev(next)->second
                            : id <= point_count        ? point_file
                                                       : segment_file;
  return text::Concat(file, ":", lines[id - 1]);
}

}  // namespace dynmesh::io
