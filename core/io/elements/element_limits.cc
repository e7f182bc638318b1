// Limits of simplices as sizes.
#include <utility>

#include "core/io/elements/element_mesh.h"
#include "core/io/elements/size_limits.h"

namespace dynmesh::io {

void AddLimits(const ElementMesh& mesh, FileFeatures& file) {
  FeatureId next_id = file.features.size();
  file.files_from[next_id + 1] = ElementMesh::Or(mesh.limit_file, mesh.file);
  for (std::size_t i = 0; i < mesh.limits.size(); ++i) {
    if (!(mesh.limits[i] > 0)) continue;
    if (mesh.dimension == 2) {
      const auto& corners = mesh.triangles[i].corners;
      std::vector<FeatureId> ring;
      for (const std::uint32_t v : corners) ring.push_back(FeatureId{v} + 1);
      file.features.push_back(
          Feature::SizePolygon(++next_id, {std::move(ring)}, TargetOfArea(mesh.limits[i])));
    } else {
      std::array<std::array<double, 3>, 4> corners;
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = mesh.positions[mesh.tetrahedra[i].corners[k]];
      }
      const InscribedBall ball = InscribedBallOf(corners);
      file.features.push_back(
          Feature::Size(++next_id, ball.centre,
                        {SizeShape::kDisc, TargetOfVolume(mesh.limits[i]), ball.radius, {}}));
    }
    file.lines.push_back(mesh.limit_lines[i]);
  }
}

}  // namespace dynmesh::io
