// Pictures of meshes, for viewing and for documents. Of a 3D mesh, a section: mesh_picture.h.
#ifndef DYNMESH_CORE_IO_PICTURES_SVG_WRITER_H_
#define DYNMESH_CORE_IO_PICTURES_SVG_WRITER_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/meshes/indexed_mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

struct SvgOptions {
  enum class Fill {
    kAngle,    // by smallest angle, in 3D dihedral: the smaller, the warmer
    kQuality,  // by circumradius / shortest edge: the nearer to rho, the warmer; over it red
    kSize,     // by shortest edge, logarithmically: the finer, the darker
    kExempt,  // pale within rho, orange if excused by a small input angle or the termination guard,
              // else red; violet if within rho but below min_dihedral. With a legend
    kRegion,  // a colour per set of polygons; pale in no polygon
    kPlain,   // one pale colour
    kNone,    // lines only
    kDihedral,  // 3D only: the colours of kAngle, with a legend in degrees
  };
  Fill fill = Fill::kAngle;
  double rho = kDefaultQuality2D;  // the bound of kQuality and kExempt
  double min_dihedral = 0;         // the second bound of kExempt in 3D; degrees, 0: no bound
  std::optional<Box> crop;         // the visible part; default: everything
  // 3D: the axis (0 to 2) of the section and its position; default: the middle of the crop, or of
  // the mesh.
  int cut_axis = 2;
  std::optional<double> cut_at;
  // 3D: not a section there, but the tetrahedra on its lower side, in perspective
  // (clip_picture.h). Polygons are brown, other triangles have the colour of their tetrahedron.
  bool is_clip = false;
  bool legend = false;  // a legend with every fill that has one
  double width = 1000;  // pixels; the height follows
  bool points = true;   // dots at input points, if there are not too many
  // Highlighted simplices (indices), such as those added by an edit.
  std::vector<std::uint32_t> highlight;
};

// INVALID_ARGUMENT for bad options and for kDihedral in 2D; UNAVAILABLE, naming the path, if it
// cannot be written. O(size). The same mesh and options give the same bytes. A legend is a strip
// below the picture, which makes the picture higher.
absl::Status WriteSvg(const IndexedMesh& mesh, const SvgOptions& options, const std::string& path);

// "angle", "dihedral", "quality", "size", "exempt", "region", "plain" or "none".
absl::StatusOr<SvgOptions::Fill> ParseFill(std::string_view text);

// INVALID_ARGUMENT if this fill is not for meshes of these options' dimension and kind.
absl::Status CheckFill(SvgOptions::Fill fill, const MeshOptions& options);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_SVG_WRITER_H_
