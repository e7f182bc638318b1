// The features of a 2D or 3D input file, with their lines. Points of the file have the ids 1..n;
// segments follow, then polygons, each in file order. Plain data.
#ifndef DYNMESH_CORE_IO_COMMON_FILE_FEATURES_H_
#define DYNMESH_CORE_IO_COMMON_FILE_FEATURES_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/io/common/feature_labels.h"
#include "core/io/common/triangle_sections.h"
#include "core/io/common/written_digits.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

// A polygon's names in a map; empty if missing.
struct PolygonName {
  FeatureId id = kNoFeature;
  std::string key;   // its "id"
  std::string name;  // the "name" of its properties
};

struct FileFeatures {
  std::vector<Feature> features;  // points, then segments, then polygons
  std::size_t point_count = 0;
  std::size_t segment_count = 0;
  std::vector<PolygonName> polygons;  // of a map, one for each polygon
  // Of a .poly or .smesh: positions of holes or regions. Finding their faces (3D: chambers) is left
  // to the user.
  std::vector<SeedRow> holes;
  std::vector<SeedRow> regions;
  FeatureLabels labels;
  std::uint64_t heights = 0;  // positions of a map with more than x and y: these are not read
  // Edges, those of polygons included, that span more than half of the globe in a map that seems to
  // be in degrees: probably meant to go the other way round.
  std::uint64_t wraps = 0;

  // Positions where rings of a topology's polygons were closed with an edge.
  std::uint64_t gaps = 0;

  NumberRounding rounding;  // of the points of a surface file

  // The line of a feature: "file:line". Empty for an id not in the file. Still correct after
  // features were removed or joined, as long as ids stay.
  std::string Where(FeatureId id) const;

  std::string point_file;    // not `segment_file` if a .poly names an external .node
  std::string segment_file;  // of polygons as well; empty for a .node
  // Of a mesh in several files: the file of the features from an id on, to the next such id.
  std::map<FeatureId, std::string> files_from;
  std::vector<int> lines;  // of the feature with id i + 1
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_FILE_FEATURES_H_
