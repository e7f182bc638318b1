// The geometry in a file, whatever its format: features to be meshed, with what the file says
// beside them. Functions are thread-safe.
#ifndef DYNMESH_CORE_IO_FORMATS_GEOMETRY_H_
#define DYNMESH_CORE_IO_FORMATS_GEOMETRY_H_

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/common/locate.h"
#include "core/io/common/written_digits.h"
#include "core/io/elements/element_mesh.h"
#include "core/io/maps/mended_rings.h"
#include "core/io/script/edit_script.h"
#include "core/io/space/face_rules.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"
#include "dynmesh/valid_features.h"

namespace dynmesh::io {

// What was done to the faces of a surface file as it was read (prepare_surface.h).
struct SurfaceCounts {
  std::size_t points = 0;  // made one with others
  std::size_t faces_twice = 0, faces_without_area = 0;
  std::size_t cut = 0;                   // faces that are not flat, to triangles
  std::size_t joined = 0, polygons = 0;  // faces in one plane, to so many polygons
  std::size_t moved = 0;                 // corners, onto planes
  double most_moved = 0;                 // the largest distance
};

// What a mesh says of features: the proof if it accepts them, which may be null, or why not.
using Verdict = absl::StatusOr<std::shared_ptr<const ValidFeatures>>;

struct Geometry {
  std::vector<Feature> features;
  MeshOptions options;                // the box: the file's own, or its bounding box
  std::vector<std::string> warnings;  // content that was skipped or mended
  // Positions of holes and regions, and the file that has them.
  std::vector<SeedRow> holes;
  std::vector<SeedRow> regions;
  std::string seed_file;
  std::vector<PolygonName> polygon_names;  // of a map's polygons
  MendedRings mended;                      // of a map, if asked for
  std::optional<SurfaceCounts> surface;    // of a surface file whose faces were mended
  NumberRounding rounding;                 // of the numbers of a surface file
  // What GeometryOptions::judge said of these features and options, if it was asked.
  std::optional<Verdict> verdict;
  // Markers, names and attributes of points; names of a map's polygons, too. Not null.
  std::shared_ptr<const FeatureLabels> labels = std::make_shared<const FeatureLabels>();
  WhereFeature where;
  // "file:line: rho" of the file's setting of a member of MeshOptions; empty if there is none.
  std::function<std::string(std::string_view)> where_option = [](std::string_view) {
    return std::string();
  };
};

struct GeometryOptions {
  bool polygons = false;                 // a map's polygons become polygon features
  bool refine = false;                   // the file is a mesh whose vertices become points
  FaceRules faces = FaceRules::kStrict;  // of surface files
  bool mend_rings = false;               // of maps (MapOptions::mended)
  bool keep_facets = false;       // of surface files: faces in one plane do not become one polygon
  bool holes_of_polygons = true;  // faces are joined to polygons of several rings, too
  bool any_script = false;        // an extension that no format is known by is an edit script's
  // What a mesh says of 3D features: where faces of a surface file are joined, it is asked of the
  // result. RESOURCE_EXHAUSTED if nothing is in conflict, but the mesh would be too large. May be
  // null.
  std::function<Verdict(const std::vector<Feature>&, const MeshOptions&)> judge;
};

// Reads a file by its extension (formats.h). INVALID_ARGUMENT as `file:line: what is wrong`, and
// for an extension of something else; UNIMPLEMENTED for formats of other programs; NOT_FOUND and
// the like if the file cannot be read. O(n lg n).
absl::StatusOr<Geometry> ReadGeometry(const std::string& path, const GeometryOptions& options = {});

// The geometry of content that was read.
Geometry GeometryOfPlane(FileFeatures file, const std::string& path);
Geometry GeometryOfSpace(FileFeatures file, const std::string& path);
Geometry GeometryOfElements(const ElementMesh& mesh, const std::string& path, bool refine);
absl::StatusOr<Geometry> GeometryOfScript(const EditScript& script);

// Parts of features with ids of their own: each has the place, the marker and the name of what it
// is a part of.
void KeepPlacesOfParts(const std::vector<std::pair<FeatureId, FeatureId>>& parts,
                       Geometry& geometry);

// Joins faces of 3D geometry that lie in one plane and have one marker (core/coplanar). `most`: the
// thickness that a mesh allows at an extent; with a tolerance of 0 it may be empty. Errors have
// places.
absl::Status JoinFaces(double tolerance, const std::function<double(double)>& most,
                       const std::string& path, Geometry& geometry);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_FORMATS_GEOMETRY_H_
