// The input of a mesh that is not refined: its points and segments are the vertices and subsegments
// of the mesh, and no operation depends on them.
#ifndef DYNMESH_CORE_MESHING_PLAIN_INPUT_H_
#define DYNMESH_CORE_MESHING_PLAIN_INPUT_H_

#include <cmath>
#include <cstdint>

#include "absl/functional/function_ref.h"
#include "core/meshing/element_store.h"
#include "core/meshing/spatial_tree.h"

namespace dynmesh::meshing {

// Thread-compatible. O(lg n) each.
template <int D>
class PlainInput {
 public:
  using Point = geometry::Point<D>;

  PlainInput(ElementStore<D>& elements, SpatialTree<D>& tree) : elements_(elements), tree_(tree) {}

  // `feature`: 0 for the domain's border.
  VertexIndex AddPoint(const Point& p, FeatureSlot feature) {
    const VertexIndex v = elements_.NewVertex();
    Vertex<D>& vertex = elements_.vertex(v);
    vertex.p = p;
    vertex.feature = feature;
    vertex.dimension = 0;
    elements_.SetPresent(v, true);
    tree_.Insert(v, p);
    return v;
  }
  void RemovePoint(VertexIndex v) {
    tree_.Remove(v, elements_.vertex(v).p);
    elements_.SetPresent(v, false);
    elements_.ReleaseVertex(v);
  }
  SubsegmentIndex AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature) {
    const SubsegmentIndex s = elements_.NewSegment(a, b, feature);
    SetInMesh(s, true);
    return s;
  }
  void RemoveSegment(SubsegmentIndex s) {
    SetInMesh(s, false);
    elements_.ReleaseSubsegment(s);
  }

  // Calls f(u) for vertices other than v, each nearer to v than the ones before; the last is the
  // nearest.
  void ForEachNearer(VertexIndex v, absl::FunctionRef<bool(VertexIndex)> f) const {
    double radius2 = INFINITY;
    tree_.VisitBall(elements_.vertex(v).p, radius2,
                    [&](std::uint32_t u, const Point&, double distance2) {
                      if (u != v && f(u)) radius2 = distance2;
                    });
  }

 private:
  // There is no time: what is in the mesh is so from the beginning.
  void SetInMesh(SubsegmentIndex s, bool is) {
    elements_.subsegment(s).exposed = is ? sac::Stamp{0} : sac::kNoStamp;
    elements_.MarkSubsegmentChanged(s);
  }

  ElementStore<D>& elements_;
  SpatialTree<D>& tree_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_PLAIN_INPUT_H_
