// Changes of the input: what the mesher adds and removes, with the requests and notifications that
// follow.
#ifndef DYNMESH_CORE_MESHING_INPUT_EDITOR_H_
#define DYNMESH_CORE_MESHING_INPUT_EDITOR_H_

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "core/meshing/complex.h"
#include "core/meshing/feature_changes.h"
#include "core/meshing/notifier.h"
#include "core/meshing/publisher.h"
#include "core/meshing/size_changes.h"

namespace dynmesh::meshing {

// Thread-compatible. Call between propagations.
template <int D, template <class> class E>
class InputEditor {
 public:
  using Point = geometry::Point<D>;
  using SizingIndex = typename SizingField<D>::Index;
  static constexpr bool kTraced = kIsTraced<D, E>;

  InputEditor(Complex<D, E>& complex, EngineOf<D, E>& engine, Notifier<D, E>& notifier,
              Publisher<D, E>& publisher)
      : complex_(complex),
        engine_(engine),
        notifier_(notifier),
        publisher_(publisher),
        changes_{.sizes = {complex.sizing, complex.rules.lo(), complex.rules.hi()}} {}

  // `feature`: 0 for the domain's border.
  VertexIndex AddPoint(const Point& p, FeatureSlot feature);
  // A vertex that areas have from the beginning (anchors.h, facet_anchors.h). `facet`: the facet
  // that it lies on, or kNil.
  VertexIndex AddAnchor(const Point& p, FeatureSlot facet);
  // A point or an anchor.
  void RemovePoint(VertexIndex v);
  // `shape`: of the segment from the lesser end to the greater.
  SubsegmentIndex AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature,
                             const SegmentShape& shape = {});
  void RemoveSegment(SubsegmentIndex s);
  SizingIndex AddSizing(const SizingRegion<D>& region);
  void RemoveSizing(SizingIndex index);
  // 3D: a polygon. The corners of its rings are input points. Its edges are input segments that are
  // present before it is added and are removed after it.
  FacetIndex AddFacet(std::span<const std::vector<VertexIndex>> rings, FeatureSlot feature);
  void RemoveFacet(FacetIndex index);

  // What came or went since the last propagation.
  struct Changes {
    FeatureChanges<D> features = {};
    SizeChanges<D> sizes;
    std::vector<Facet> facets = {};
    std::vector<FacetIndex> new_facets = {};  // those that came and are present
    // A propagation has begun with some of them and was interrupted before it had settled them.
    bool begun = false;
  };
  Changes& changes() { return changes_; }

  // 3D: points not yet in the triangulation, if there is one.
  std::vector<VertexIndex>& pending() { return pending_; }

 private:
  // From now on features are kept by position. Nothing has depended on their positions so far, so
  // the present ones count as unchanged.
  void IndexFeatures();
  VertexIndex AddVertex(const Point& p, int dimension, FeatureSlot feature);
  InputFeature<D> FeatureOf(const Subsegment<D>& whole) const {
    InputFeature<D> feature = complex_.FeatureOf(whole.a, whole.b);
    feature.unsplit = IsUnsplit(whole);
    return feature;
  }
  void AddFeature(const InputFeature<D>& feature);
  void RemoveFeature(const InputFeature<D>& feature);

  Complex<D, E>& complex_;
  EngineOf<D, E>& engine_;
  Notifier<D, E>& notifier_;
  Publisher<D, E>& publisher_;
  bool indexes_features_ = false;
  Changes changes_;
  std::vector<VertexIndex> pending_;
  VertexIndex near_ = 0;  // 2D: the last vertex inserted into the triangulation, if there is one
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
VertexIndex InputEditor<D, E>::AddPoint(const Point& p, FeatureSlot feature) {
  const VertexIndex v = AddVertex(p, 0, feature);
  if (indexes_features_) AddFeature(complex_.FeatureOf(v, v));
  return v;
}

template <int D, template <class> class E>
VertexIndex InputEditor<D, E>::AddAnchor(const Point& p, FeatureSlot facet) {
  return AddVertex(p, facet == kNil ? D : 2, facet);
}

template <int D, template <class> class E>
VertexIndex InputEditor<D, E>::AddVertex(const Point& p, int dimension, FeatureSlot feature) {
  const VertexIndex v = complex_.elements.NewVertex();
  Vertex<D>& vertex = complex_.vertex(v);
  vertex.p = p;
  vertex.birth = engine_.beginning();
  vertex.feature = feature;
  vertex.dimension = static_cast<std::uint8_t>(dimension);
  complex_.SetPresent(v, true);
  if (kTraced && !complex_.run.has_triangulation()) complex_.appeared.push_back(v);
  if (complex_.needs_tree() || !complex_.border_only) complex_.tree.Insert(v, p);
  if (complex_.run.has_triangulation() && !complex_.run.triangulation().Contains(v)) {
    if constexpr (D == 2) {
      complex_.run.triangulation().Insert(v, p, near_);
      near_ = v;
    } else {
      pending_.push_back(v);
    }
  }
  notifier_.OfVertex(v, true, engine_.beginning());
  if (complex_.needs_tree()) engine_.Request(kNearest, v, NearestEpoch());
  return v;
}

template <int D, template <class> class E>
void InputEditor<D, E>::RemovePoint(VertexIndex v) {
  if constexpr (kTraced) {
    const bool is_feature = complex_.vertex(v).dimension == 0;
    if (indexes_features_ && is_feature) RemoveFeature(complex_.FeatureOf(v, v));
    engine_.Unrequest(kNearest, v, NearestEpoch());
    publisher_.WithdrawVertex(v, engine_.beginning());
    complex_.elements.ReleaseVertex(v);
  }
}

template <int D, template <class> class E>
SubsegmentIndex InputEditor<D, E>::AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature,
                                              const SegmentShape& shape) {
  if (!complex_.needs_tree() && complex_.border_only && feature != 0) {
    // So far nothing needed the tree. Subsegments are found through it.
    for (VertexIndex v = 0; v < complex_.elements.vertex_end(); ++v) {
      complex_.tree.Insert(v, complex_.vertex(v).p);
    }
  }
  if (feature != 0) {
    complex_.border_only = false;
    IndexFeatures();
  }
  const SubsegmentIndex s = complex_.elements.NewSegment(a, b, feature);
  Subsegment<D>& sub = complex_.subsegment(s);
  sub.split_rule = SplitRule::Whole(shape, LengthOf(complex_.vertex(a).p, complex_.vertex(b).p));
  // No feature is near the sides of the domain (DomainBox).
  if (feature != 0) AddFeature(FeatureOf(sub));
  if (feature == 0 || IsUnsplit(sub)) {
    engine_.Request(kCheck, s, FirstCheckEpoch());
  } else {
    engine_.Request(kPresplit, s, PresplitEpoch());
  }
  return s;
}

template <int D, template <class> class E>
void InputEditor<D, E>::RemoveSegment(SubsegmentIndex s) {
  if constexpr (kTraced) {
    RemoveFeature(FeatureOf(complex_.subsegment(s)));
    if (IsUnsplit(complex_.subsegment(s))) {
      engine_.Unrequest(kCheck, s, FirstCheckEpoch());
    } else {
      engine_.Unrequest(kPresplit, s, PresplitEpoch());
    }
    complex_.elements.ReleaseSubsegment(s);
  }
}

template <int D, template <class> class E>
typename InputEditor<D, E>::SizingIndex InputEditor<D, E>::AddSizing(
    const SizingRegion<D>& region) {
  const auto index = complex_.sizing.Add(region);
  changes_.sizes.Come(index);
  IndexFeatures();
  return index;
}

template <int D, template <class> class E>
void InputEditor<D, E>::RemoveSizing(SizingIndex index) {
  changes_.sizes.Go(index);
  complex_.sizing.Remove(index);
}

template <int D, template <class> class E>
FacetIndex InputEditor<D, E>::AddFacet(std::span<const std::vector<VertexIndex>> rings,
                                       FeatureSlot feature) {
  if constexpr (D == 3) {
    const FacetIndex index = complex_.facets.Add(
        Facet(rings, feature, [this](VertexIndex v) { return complex_.vertex(v).p; }));
    complex_.run.MeetFacet();
    changes_.facets.push_back(complex_.facets[index]);
    changes_.new_facets.push_back(index);
    return index;
  }
  return kNil;
}

template <int D, template <class> class E>
void InputEditor<D, E>::RemoveFacet(FacetIndex index) {
  if constexpr (D == 3) {
    changes_.facets.push_back(complex_.facets[index]);
    std::erase(changes_.new_facets, index);
    complex_.facets.Remove(index);
  }
}

template <int D, template <class> class E>
void InputEditor<D, E>::IndexFeatures() {
  if (std::exchange(indexes_features_, true)) return;
  for (VertexIndex v = 0; v < complex_.elements.vertex_end(); ++v) {
    const Vertex<D>& vertex = complex_.vertex(v);
    const bool is_point = vertex.present && vertex.creator == sac::kNoOp;
    if (is_point && vertex.feature != 0) complex_.features.Add(complex_.FeatureOf(v, v));
  }
}

template <int D, template <class> class E>
void InputEditor<D, E>::AddFeature(const InputFeature<D>& feature) {
  complex_.features.Add(feature);
  if (feature.unsplit) complex_.unsplit.Add(feature);
  if constexpr (kTraced) changes_.features.emplace_back(feature, true);
}

template <int D, template <class> class E>
void InputEditor<D, E>::RemoveFeature(const InputFeature<D>& feature) {
  complex_.features.Remove(feature);
  if (feature.unsplit) complex_.unsplit.Remove(feature);
  if constexpr (kTraced) changes_.features.emplace_back(feature, false);
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_INPUT_EDITOR_H_
