// A facet in the units of an index's cells. Immutable, thread-safe.
#ifndef DYNMESH_CORE_PLC_GRID_FACET_H_
#define DYNMESH_CORE_PLC_GRID_FACET_H_

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/plc/cell_grid.h"
#include "core/plc/facet.h"

namespace dynmesh::plc {

struct GridFacet {
  std::shared_ptr<const Facet> facet;
  UnitPoint<3> lo{}, hi{};  // its box
  double offset = 0;        // distance of its plane from the origin, in units
  double thickness = 0;     // its deviation, in units

  GridFacet() = default;
  GridFacet(const Facet& f, const CellGrid<3>& grid)
      : facet(std::make_shared<const Facet>(f)),
        lo(grid.ToUnits(f.lo())),
        hi(grid.ToUnits(f.hi())),
        offset(geometry::Dot(f.plane().normal, grid.ToUnits(f.plane().origin))),
        thickness(grid.UnitsOf(f.deviation())) {}

  double Extent() const { return std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]}); }

  // Does the part of its plane in its box, both with its thickness, meet the closed `cell` grown by
  // `reach` >= 1/4 on every side? Conservative: may return true needlessly (if it misses by a
  // fraction of a unit), never false wrongly.
  bool Meets(const Cell<3>& cell, double reach) const {
    const double half = static_cast<double>(cell.side) / 2 + reach + thickness;
    const geometry::Vector3& n = facet->plane().normal;
    double distance = -offset;
    for (int i = 0; i < 3; ++i) {
      if (cell.Hi(i) + reach + thickness < lo[i] || cell.Lo(i) - reach - thickness > hi[i]) {
        return false;
      }
      distance += n[i] * (cell.Lo(i) + static_cast<double>(cell.side) / 2);
    }
    return std::abs(distance) <= half * (std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]));
  }
  // Calls visit(i) for the children of `cell` that it may meet.
  template <class Visit>
  void ForChildrenNear(const Cell<3>& cell, double reach, Visit visit) const {
    cell.ForChildrenNear(lo, hi, reach + thickness, visit);
  }
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_GRID_FACET_H_
