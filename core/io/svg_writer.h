// Pictures of meshes, to look at and to put into documents. Of a mesh of space, a cut through it:
// mesh_picture.h.
#ifndef DYNMESH_CORE_IO_SVG_WRITER_H_
#define DYNMESH_CORE_IO_SVG_WRITER_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/indexed_mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

struct SvgOptions {
  enum class Fill {
    kAngle,     // by smallest angle, in space dihedral: the smaller, the warmer
    kQuality,   // by circumradius / shortest edge: the nearer to rho, the warmer; over it red
    kSize,      // by shortest edge, logarithmically: the finer, the darker
    kExempt,    // pale within rho, orange if a small input angle or the termination guard excuses
                // more, else red; violet what is within rho and below min_dihedral. With a legend
    kRegion,    // a colour for each set of polygons, what lies in none is pale
    kPlain,     // one pale colour
    kNone,      // lines only
    kDihedral,  // the colours of kAngle in space, with a legend in degrees; not in the plane
  };
  Fill fill = Fill::kAngle;
  double rho = kDefaultQuality2D;  // what kQuality and kExempt judge by
  double min_dihedral = 0;         // in space what kExempt judges by, too; degrees, 0: no bound
  std::optional<Box> crop;         // what is shown; default: everything
  // In space: across which axis (0 to 2) it is cut, and where; default: in the middle of the crop,
  // or of the mesh.
  int cut_axis = 2;
  std::optional<double> cut_at;
  double width = 1000;  // pixels; the height follows
  bool points = true;   // dots at input points, if they are few enough to tell apart
  // Simplices to stand out (indices), as those that an edit added.
  std::vector<std::uint32_t> highlight;
};

// INVALID_ARGUMENT for bad options and for kDihedral of a mesh of the plane; UNAVAILABLE, naming
// the path, if it cannot be written. O(size). The same mesh and options make the same bytes. A
// legend is a strip below the picture, which makes it higher.
absl::Status WriteSvg(const IndexedMesh& mesh, const SvgOptions& options, const std::string& path);

// "angle", "dihedral", "quality", "size", "exempt", "region", "plain" or "none".
absl::StatusOr<SvgOptions::Fill> ParseFill(std::string_view text);

// INVALID_ARGUMENT if a mesh of `dimension` (2 or 3) cannot be filled so.
absl::Status CheckFill(SvgOptions::Fill fill, int dimension);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SVG_WRITER_H_
