// Triangles over rho because of unsplit segments (Feature::unsplit): the point that would fix one
// lies in the circle over such a segment, or did so when it was tried. Found from the mesh and the
// features. Thread-compatible.
#ifndef DYNMESH_CORE_QUALITY_UNSPLIT_GAPS_H_
#define DYNMESH_CORE_QUALITY_UNSPLIT_GAPS_H_

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/box_tree.h"
#include "core/geometry/point.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::quality {

class UnsplitGaps {
 public:
  // `mesh`, of dimension 2, must outlive the object. `features`: of its input; points and what is
  // unsplit count. O(n lg n) if any is unsplit.
  UnsplitGaps(const Mesh& mesh, std::span<const Feature> features, double rho);

  // Is the triangle of these rows, counter-clockwise and over rho, such a triangle?
  bool Has(const std::array<std::size_t, 3>& rows) const;

 private:
  struct Circle {
    geometry::Point2 centre;
    double radius2;
  };
  geometry::Point2 At(std::size_t row) const {
    return {{mesh_.vertices.coordinates[2 * row], mesh_.vertices.coordinates[2 * row + 1]}};
  }
  // Does the segment from x to y, maybe a point, meet a circle?
  bool MeetsCircle(const geometry::Point2& x, const geometry::Point2& y) const;

  const Mesh& mesh_;
  const double rho_;
  std::vector<Circle> circles_;
  boxes::BoxTree<2> tree_;
};

}  // namespace dynmesh::quality

#endif  // DYNMESH_CORE_QUALITY_UNSPLIT_GAPS_H_
