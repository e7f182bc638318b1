// A surface file as input of a mesh.
#ifndef DYNMESH_CORE_IO_FORMATS_PREPARE_SURFACE_H_
#define DYNMESH_CORE_IO_FORMATS_PREPARE_SURFACE_H_

#include <string>

#include "absl/status/statusor.h"
#include "core/io/common/file_features.h"
#include "core/io/formats/geometry.h"

namespace dynmesh::io {

// Mends the faces (surface_mending.h): points nearer than what a mesh refuses are one. Then joins
// those in one plane within the rounding of the file's numbers (coplanar/join_flat.h), unless they
// are to be kept, or have other markers or names. What a mesh would refuse for that stays as it is.
absl::StatusOr<Geometry> PrepareSurface(FileFeatures file, const std::string& path,
                                        const GeometryOptions& options);

// Joins faces in the same way, of a surface that has been changed since it was read, and bounds it
// by a new box. Returns how many. REQUIRES: polygons have one ring each; no two points are at one
// place.
SurfaceCounts JoinFacesInOnePlane(const GeometryOptions& options, Geometry& geometry);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_FORMATS_PREPARE_SURFACE_H_
