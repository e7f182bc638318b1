// What differs between the shapes of sizing features: what is legal, and how large the region is.
// One class a shape. Stateless, thread-safe; O(1), of a polygon O(corners), of a capsule
// O(vertices).
#ifndef DYNMESH_CORE_PLC_SIZE_RULES_H_
#define DYNMESH_CORE_PLC_SIZE_RULES_H_

#include <algorithm>
#include <optional>
#include <string>

#include "core/plc/delta.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

template <int D>
struct Extent {
  geometry::Point<D> lo{}, hi{};
  double Measure() const {
    double measure = 1;
    for (int k = 0; k < D; ++k) measure *= std::max(0.0, hi[k] - lo[k]);
    return measure;
  }
};

template <int D>
Extent<D> Common(const Extent<D>& a, const Extent<D>& b) {
  Extent<D> common;
  for (int k = 0; k < D; ++k) {
    common.lo[k] = std::max(a.lo[k], b.lo[k]);
    common.hi[k] = std::min(a.hi[k], b.hi[k]);
  }
  return common;
}

// A bound from either side of the part of a region in the domain: it is within `around`; all of
// `box` and all that is nearer than `radius` to the segment `from` `to` is in it.
template <int D>
struct SizeBounds {
  Extent<D> around;
  Extent<D> box;
  geometry::Point<D> from{}, to{};
  double radius = 0;

  // Is the whole cell certainly within `radius`?
  bool Holds(const Extent<D>& cell) const;
};

// For an error: its reason, and "is ... ; what to do".
struct SizeFault {
  const char* reason;
  std::string what;
};

template <int D>
class SizeRules {
 public:
  virtual ~SizeRules() = default;
  // What is wrong with the shape in a mesh with that box. REQUIRES: its numbers are finite.
  virtual std::optional<SizeFault> FaultOf(const SizeFeature<D>& size, const Box& box) const = 0;
  // The area or volume; not less.
  virtual double Measure(const SizeFeature<D>& size) const = 0;
  // Of the part in the domain; not more.
  virtual double LeastMeasure(const SizeFeature<D>& size, const Box& domain) const = 0;
  // The distance of two positions of that part, or of its border, that are connected there; not
  // more. Tells how many vertices a thin region has.
  virtual double LeastLength(const SizeFeature<D>& size, const Box& domain) const = 0;
  virtual SizeBounds<D> Bounds(const SizeFeature<D>& size, const Box& domain) const = 0;
};

// Null if there is no such shape in D dimensions.
template <int D>
const SizeRules<D>* FindSizeRules(SizeShape shape);
// REQUIRES: the shape is legal.
template <int D>
const SizeRules<D>& RulesOf(const SizeFeature<D>& size) {
  return *FindSizeRules<D>(size.sizing.shape);
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_SIZE_RULES_H_
