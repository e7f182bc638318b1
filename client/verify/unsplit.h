// Segments and edges of polygons that the input marks as unsplit: what they excuse, for the checks
// of quality and sizes. 2D; in long double.
#ifndef DYNMESH_CLIENT_VERIFY_UNSPLIT_H_
#define DYNMESH_CLIENT_VERIFY_UNSPLIT_H_

#include <utility>
#include <vector>

#include "client/verify/vectors.h"
#include "core/base/box_tree.h"
#include "core/io/meshes/mesh_files.h"
#include "dynmesh/feature.h"

namespace dynmesh::cli {

// The pairs of points, by id, that must be joined by one edge. Maybe some several times.
std::vector<std::pair<FeatureId, FeatureId>> UnsplitJoints(const std::vector<Feature>& features);

class UnsplitCircles {
 public:
  // `features`: null if they are unknown; then nothing is excused.
  explicit UnsplitCircles(const std::vector<Feature>* features);

  // Is the triangle over rho since the point that would mend it is in a circle over an unsplit
  // segment, or was when it was tried? That is a point of the bisector of an edge that is too short
  // for the triangle, between the circumcenter and the point at which the edge's triangle is just
  // good.
  bool Excuse(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t, double rho) const;
  // May a target length be missed for the same reason? Also true if the circumcenter is in a
  // circle.
  bool ExcuseSize(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t) const;

 private:
  struct Circle {
    Vector a, b;
  };
  bool Meet(const Vector& x, const Vector& y) const;

  std::vector<Circle> circles_;
  boxes::BoxTree<2> tree_;
};

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_UNSPLIT_H_
