// A facet in the units of an index's cells. Immutable, thread-safe.
#ifndef DYNMESH_CORE_PLC_GRID_FACET_H_
#define DYNMESH_CORE_PLC_GRID_FACET_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "core/geometry/circumball.h"
#include "core/plc/cell_grid.h"
#include "core/plc/facet.h"

namespace dynmesh::plc {

struct GridFacet {
  std::shared_ptr<const Facet> facet;
  UnitPoint<3> lo{}, hi{};  // its box
  double offset = 0;        // distance of its plane from the origin, in units
  double thickness = 0;     // its deviation, in units
  // The strip of its plane between two lines parallel to its longest edge: across . x from `from`
  // to `to`. A needle that lies aslant fills little of its box.
  geometry::Vector3 across{};
  double from = 0, to = 0;

  GridFacet() = default;
  GridFacet(const Facet& f, const CellGrid<3>& grid)
      : facet(std::make_shared<const Facet>(f)),
        lo(grid.ToUnits(f.lo())),
        hi(grid.ToUnits(f.hi())),
        offset(geometry::Dot(f.plane().normal, grid.ToUnits(f.plane().origin))),
        thickness(grid.UnitsOf(f.deviation())) {
    SetStrip(grid);
  }

  double Extent() const { return std::max({hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]}); }

  // Does the part of its plane in its box and strip, all with its thickness, meet the closed `cell`
  // grown by `reach` >= 1/4 on every side? Conservative: may return true needlessly (if it misses
  // by some units), never false wrongly.
  bool Meets(const Cell<3>& cell, double reach) const {
    const double half = static_cast<double>(cell.side) / 2 + reach + thickness;
    const geometry::Vector3& n = facet->plane().normal;
    double distance = -offset, along = 0, widest = 0;
    for (int i = 0; i < 3; ++i) {
      if (cell.Hi(i) + reach + thickness < lo[i] || cell.Lo(i) - reach - thickness > hi[i]) {
        return false;
      }
      const double middle = cell.Lo(i) + static_cast<double>(cell.side) / 2;
      distance += n[i] * middle;
      along += across[i] * middle;
      widest += std::abs(across[i]) * (half + 1);
    }
    if (along + widest < from || along - widest > to) return false;
    return std::abs(distance) <= half * (std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]));
  }
  // Calls visit(i) for the children of `cell` that it may meet.
  template <class Visit>
  void ForChildrenNear(const Cell<3>& cell, double reach, Visit visit) const {
    cell.ForChildrenNear(lo, hi, reach + thickness, visit);
  }

 private:
  void SetStrip(const CellGrid<3>& grid);
};

inline void GridFacet::SetStrip(const CellGrid<3>& grid) {
  std::vector<UnitPoint<3>> corners;
  geometry::Vector3 longest{};
  for (const auto& ring : facet->feature().positions) {
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
      corners.push_back(grid.ToUnits(ring[i]));
      const geometry::Vector3 edge = geometry::Difference(ring[i].c, ring[j].c);
      if (geometry::Dot(edge, edge) > geometry::Dot(longest, longest)) longest = edge;
    }
  }
  const geometry::Vector3 normal = geometry::Cross(facet->plane().normal, longest);
  const double length = std::sqrt(geometry::Dot(normal, normal));
  if (!(length > 0)) return;  // then everything is in the strip
  for (int i = 0; i < 3; ++i) across[i] = normal[i] / length;
  for (const UnitPoint<3>& corner : corners) {
    const double at = across[0] * corner[0] + across[1] * corner[1] + across[2] * corner[2];
    from = &corner == corners.data() ? at : std::min(from, at);
    to = &corner == corners.data() ? at : std::max(to, at);
  }
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_GRID_FACET_H_
