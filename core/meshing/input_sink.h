// How features come into a mesher: one call each. A caller sees a mesher as an InputSink, and need
// not know its type. Calls come between runs. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_INPUT_SINK_H_
#define DYNMESH_CORE_MESHING_INPUT_SINK_H_

#include <span>
#include <vector>

#include "core/meshing/element_store.h"
#include "core/meshing/facet_field.h"
#include "core/meshing/shells.h"
#include "core/meshing/sizing_field.h"

namespace dynmesh::meshing {

// A mesher that takes features.
template <int D>
class InputSink {
 public:
  using Point = geometry::Point<D>;
  using SizingIndex = typename SizingField<D>::Index;

  // `feature`: 0 for the domain's border.
  virtual VertexIndex AddPoint(const Point& p, FeatureSlot feature) = 0;
  // `shape`: of the segment from the lesser end to the greater.
  virtual SubsegmentIndex AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature,
                                     const SegmentShape& shape) = 0;
  virtual SizingIndex AddSizing(const SizingRegion<D>& region) = 0;
  // 3D: a polygon. The corners of its rings are input points. Its edges are input segments that are
  // present before it is added and are removed after it.
  virtual FacetIndex AddFacet(std::span<const std::vector<VertexIndex>> rings,
                              FeatureSlot feature) = 0;

  // What has become of the features.
  virtual const ElementStore<D>& elements() const = 0;
  virtual const FacetField& facets() const = 0;

 protected:
  ~InputSink() = default;
};

// A mesher that also forgets features.
template <int D>
class EditableSink : public InputSink<D> {
 public:
  virtual void RemovePoint(VertexIndex v) = 0;
  virtual void RemoveSegment(SubsegmentIndex s) = 0;
  virtual void RemoveSizing(typename InputSink<D>::SizingIndex index) = 0;
  virtual void RemoveFacet(FacetIndex index) = 0;

 protected:
  ~EditableSink() = default;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_INPUT_SINK_H_
