// Triangles over rho because of the termination guard: the point that would fix one lies in the
// diametral circle of a subsegment about as short as the triangle's edges. A finished mesh has such
// triangles only where the guard kept the subsegment from being split (meshing/rules.h). Found from
// the mesh alone. Thread-compatible.
#ifndef DYNMESH_CORE_QUALITY_GUARDED_GAPS_H_
#define DYNMESH_CORE_QUALITY_GUARDED_GAPS_H_

#include <array>
#include <cstddef>
#include <vector>

#include "core/base/id_table.h"
#include "core/geometry/point.h"
#include "dynmesh/mesh.h"

namespace dynmesh::quality {

class GuardedGaps {
 public:
  // `mesh` (of dimension 2) and `row_of`, the rows of its vertices by id, must outlive the object.
  // O(1); the first query O(size).
  GuardedGaps(const Mesh& mesh, const IdTable& row_of, double rho)
      : mesh_(mesh), row_of_(row_of), rho_(rho) {}

  // Is the triangle of these rows, counter-clockwise and over rho, such a triangle? O(subsegments)
  // for the first kMostQuestions queries; false for later ones.
  bool Has(const std::array<std::size_t, 3>& rows);

 private:
  static constexpr int kMostQuestions = 1000;
  struct Ball {
    geometry::Point2 centre;
    double radius2;
  };
  geometry::Point2 At(std::size_t row) const {
    return {{mesh_.vertices.coordinates[2 * row], mesh_.vertices.coordinates[2 * row + 1]}};
  }
  void FindBalls();

  const Mesh& mesh_;
  const IdTable& row_of_;
  const double rho_;
  std::vector<Ball> balls_;
  int questions_ = 0;
};

}  // namespace dynmesh::quality

#endif  // DYNMESH_CORE_QUALITY_GUARDED_GAPS_H_
