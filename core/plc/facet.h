// A 3D facet with its plane: queries for points in it and for the sides of its edges.
//
// The inside is even-odd (geometry/facet_interior.h). Near an edge rounding decides, far nearer
// than features may be. A facet is checked after its edges: these meet in corners only. Rings may
// cross there. Immutable, thread-safe. Construction O(corners lg^2 corners); `Holds`, `OpensTo`,
// `IsInsideLeftOf` and `InwardOf` O(lg^2 corners); the others O(lg corners).
#ifndef DYNMESH_CORE_PLC_FACET_H_
#define DYNMESH_CORE_PLC_FACET_H_

#include <cstddef>
#include <span>
#include <tuple>
#include <vector>

#include "core/geometry/facet_interior.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/point.h"
#include "core/plc/delta.h"
#include "dynmesh/feature.h"

namespace dynmesh::plc {

class Facet {
 public:
  // One visit of a ring to a point.
  struct Corner {
    FeatureId id;
    std::size_t ring, at;
    friend bool operator<(const Corner& a, const Corner& b) {
      return std::tie(a.id, a.ring, a.at) < std::tie(b.id, b.ring, b.at);
    }
  };

  Facet() = default;
  explicit Facet(FacetFeature feature);

  FeatureId id() const { return feature_.id; }
  const FacetFeature& feature() const { return feature_; }
  const geometry::FacetPlane& plane() const { return plane_; }
  // The largest distance of a corner from the plane.
  double deviation() const { return bounds_.deviation; }
  // The area of the largest ring.
  double area() const { return area_; }
  // The box of its corners.
  const geometry::Point3& lo() const { return bounds_.lo; }
  const geometry::Point3& hi() const { return bounds_.hi; }
  double Extent() const;

  // All visits, sorted by id; the visits to one point.
  const std::vector<Corner>& corners() const { return corners_; }
  std::span<const Corner> At(FeatureId point) const;
  bool HasCorner(FeatureId point) const { return !At(point).empty(); }
  const geometry::Point3& PositionOf(const Corner& c) const {
    return feature_.positions[c.ring][c.at];
  }
  // The corner after it, or before it, on its ring.
  Corner Beside(const Corner& c, bool next) const;
  bool HasEdge(FeatureId p, FeatureId q) const;

  // Is the projection of `p` inside?
  bool Holds(const geometry::Point3& p) const { return interior_.Holds(plane_.Foot(p)); }
  // Does `direction`, projected into the plane, lead from the corner `point` into the inside? False
  // if it leads along an edge.
  bool OpensTo(FeatureId point, const geometry::Vector3& direction) const;
  // Is the inside to the left of the edge from `c` to the next corner, seen against the normal?
  bool IsInsideLeftOf(const Corner& c) const;
  // The unit vector in the plane, normal to the edge from `c` to the next corner, into the inside.
  geometry::Vector3 InwardOf(const Corner& c) const;

 private:
  // The vector in the plane, normal to the edge from `c` to the next corner, to the left; as long
  // as the edge.
  geometry::Vector3 LeftOf(const Corner& c) const;

  FacetFeature feature_;
  geometry::FacetPlane plane_;
  geometry::FacetInterior interior_;
  geometry::FacetBounds bounds_;
  double area_ = 0;
  std::vector<Corner> corners_;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_FACET_H_
