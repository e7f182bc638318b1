// Maps in JSON: GeoJSON (RFC 7946) and TopoJSON, as features.
//
// Points become 1..n in file order, the edges of lines and rings n+1..n+m. Equal
// coordinates are one point, an edge that stands twice (the border of two neighbours) is
// one segment, repeated positions are dropped. Of a topology every arc that an object uses
// is taken once, in the order of `arcs`, then the objects' own points. What is read of a
// position is x and y; properties and bounding boxes are not looked at.
//
// With `polygons` rings make no segments but polygon features, with the ids after the segments',
// in file order: one for a Polygon, and one for all of a MultiPolygon. They share points; an
// `id` and a property `name` are noted.
#ifndef DYNMESH_CORE_IO_MAP_FILES_H_
#define DYNMESH_CORE_IO_MAP_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/file_features.h"
#include "core/io/json_document.h"

namespace dynmesh::io {

struct MapOptions {
  bool polygons = false;
  JsonLimits limits = {};
};

// Which of the two formats it is stands in the file ("type"). INVALID_ARGUMENT as
// `file:line: what is wrong` for what is neither, and for a coordinate of magnitude above
// 2^200; NOT_FOUND and the like if the file cannot be read. O(file) expected time.
absl::StatusOr<FileFeatures> ReadMapFile(const std::string& path, const MapOptions& options = {});

// Of a parsed file.
absl::StatusOr<FileFeatures> ReadGeoJson(const JsonDocument& json, bool polygons = false);
absl::StatusOr<FileFeatures> ReadTopoJson(const JsonDocument& json, bool polygons = false);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MAP_FILES_H_
