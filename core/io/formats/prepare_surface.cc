#include "core/io/formats/prepare_surface.h"

#include <utility>

#include "core/base/rounding.h"
#include "core/io/space/surface_mending.h"
#include "dynmesh/options.h"

namespace dynmesh::io {
namespace {

// The options of a mesh of the file.
MeshOptions OptionsOf(const FileFeatures& file) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = DefaultQuality(3);
  options.min_dihedral = DefaultMinDihedral(3);
  options.box = BoundingBox(file.features, 3);
  return options;
}

}  // namespace

absl::StatusOr<Geometry> PrepareSurface(FileFeatures file, const std::string& path,
                                        const GeometryOptions& options) {
  (void)options;
  SurfacePreparation prepared;
  prepared.is_surface = true;
  const MeshOptions mesh = OptionsOf(file);
  // Coordinates out of range are refused with their feature, by the mesh.
  const double near = ValidateOptions(mesh).ok() ? LeastDistance(mesh) : 0;
  prepared.mends = MendSurface(near, file);
  Geometry geometry = GeometryOfSpace(std::move(file), path);
  geometry.prepared = prepared;
  return geometry;
}

}  // namespace dynmesh::io
