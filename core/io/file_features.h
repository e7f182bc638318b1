// The features of an input file, of the plane or of space, and where each stands in it.
// Points of the file have the ids 1..n, segments follow, then polygons, each in file order.
// Plain data.
#ifndef DYNMESH_CORE_IO_FILE_FEATURES_H_
#define DYNMESH_CORE_IO_FILE_FEATURES_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/io/triangle_sections.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

// What a map calls a polygon: empty where it says nothing.
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
  // Of a .poly or .smesh: places whose faces (in space: rooms) are holes or regions. Which face
  // that is, is not for here.
  std::vector<SeedRow> holes;
  std::vector<SeedRow> regions;
  // What the file has and the mesh will not show.
  std::uint64_t attributes = 0;  // a vertex
  std::uint64_t markers = 0;     // that are not 0, of vertices, segments and facets
  std::uint64_t heights = 0;     // positions of a map with more than x and y
  // Edges, those of polygons included, that span more than half of the way round in a map that
  // seems to be in degrees: they were meant to go the other way round.
  std::uint64_t wraps = 0;

  // Places where rings of a topology's polygons were closed with an edge.
  std::uint64_t gaps = 0;

  // Where a feature stands: "file:line". Empty for an id that the file does not have. Goes on
  // saying it when features were taken out or joined, as long as ids stay.
  std::string Where(FeatureId id) const;

  std::string point_file;    // not `segment_file` if a .poly names an external .node
  std::string segment_file;  // of polygons as well; empty for a .node
  std::vector<int> lines;    // of the feature with id i + 1
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_FILE_FEATURES_H_
