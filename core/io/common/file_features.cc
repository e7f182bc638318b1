#include "core/io/common/file_features.h"

#include "core/base/text.h"

namespace dynmesh::io {

std::string FileFeatures::Where(FeatureId id) const {
  if (id == kNoFeature || id > lines.size()) return "";
  return text::Concat(id <= point_count ? point_file : segment_file, ":", lines[id - 1]);
}

}  // namespace dynmesh::io
