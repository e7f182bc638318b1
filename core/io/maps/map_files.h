// Maps in JSON: GeoJSON (RFC 7946) and TopoJSON, as features.
//
// Points become 1..n in file order, the edges of lines and rings n+1..n+m. Equal coordinates are
// one point; a repeated edge (the border of two neighbours) is one segment; repeated positions are
// dropped. Of a topology, every arc that an object uses is taken once, in the order of `arcs`, then
// the objects' own points. Only x and y of a position are read. Properties and bounding boxes are
// ignored.
//
// With `polygons`, rings become polygon features instead of segments, with ids after the segments',
// in file order: one for a Polygon, one for a whole MultiPolygon. They share points. An `id` and a
// property `name` are recorded.
#ifndef DYNMESH_CORE_IO_MAPS_MAP_FILES_H_
#define DYNMESH_CORE_IO_MAPS_MAP_FILES_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/maps/json_document.h"
#include "core/io/maps/mended_rings.h"

namespace dynmesh::io {

struct MapOptions {
  bool polygons = false;
  JsonLimits limits = {};
  // If given, rings of GeoJSON of fewer than four positions and open rings are mended and counted
  // here; else they are INVALID_ARGUMENT. (A topology's are closed in any case.)
  MendedRings* mended = nullptr;
};

// The file's "type" determines the format. INVALID_ARGUMENT as `file:line: what is wrong` for other
// formats, and for a coordinate of magnitude above 2^200; NOT_FOUND and the like if the file cannot
// be read. O(file) expected time.
absl::StatusOr<FileFeatures> ReadMapFile(const std::string& path, const MapOptions& options = {});

// From a parsed file.
absl::StatusOr<FileFeatures> ReadGeoJson(const JsonDocument& json, bool polygons = false,
                                         MendedRings* mended = nullptr);
absl::StatusOr<FileFeatures> ReadTopoJson(const JsonDocument& json, bool polygons = false);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MAPS_MAP_FILES_H_
