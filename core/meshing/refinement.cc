#include "core/meshing/refinement.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/meshing/changes.h"
#include "core/meshing/complete.h"
#include "core/meshing/neighbourhood.h"
#include "core/meshing/segments.h"

namespace dynmesh::meshing {

#ifdef DYNMESH_MUTATE_FILTERS
Term switched_off = Term::kCount;
#endif

template <template <class> class E>
Refinement<E>::Refinement(const MeshOptions& options, mesh::DelaunayTriangulation* triangulation)
    : rules_(options),
      limits_(options.limits),
      triangulation_(triangulation),
      tree_(rules_.lo(), rules_.hi()),
      sizing_(rules_.lo(), rules_.hi()),
      engine_(*this) {
  AddBox();
  if (options.max_edge > 0) {
    const Box& box = options.box;
    sizing_.Add({{{box.lo[0], box.lo[1]}}, {{box.hi[0], box.hi[1]}}, 0, options.max_edge, nullptr});
  }
}

// --- Input ----------------------------------------------------------------------------

// 24 points, counter-clockwise, the corners first (a triangulation begins with them).
template <template <class> class E>
void Refinement<E>::AddBox() {
  constexpr int kSide = 6;
  const Point2 &lo = rules_.lo(), &hi = rules_.hi();
  const double step = rules_.grid_spacing();
  std::array<VertexIndex, 4 * kSide> border;
  const auto at = [&](int side, int i) -> Point2 {
    const auto along = [&](int axis) { return i == 0 ? lo[axis] : lo[axis] + i * step; };
    const auto back = [&](int axis) { return i == 0 ? hi[axis] : lo[axis] + (kSide - i) * step; };
    switch (side) {
      case 0:
        return {{along(0), lo[1]}};
      case 1:
        return {{hi[0], along(1)}};
      case 2:
        return {{back(0), hi[1]}};
      default:
        return {{lo[0], back(1)}};
    }
  };
  if (triangulation_ != nullptr) triangulation_->Reset(lo, hi, {0, 1, 2, 3});
  for (int side = 0; side < 4; ++side) border[side * kSide] = AddPoint(at(side, 0), 0);
  for (int side = 0; side < 4; ++side) {
    near_ = border[side * kSide];
    for (int i = 1; i < kSide; ++i) border[side * kSide + i] = AddPoint(at(side, i), 0);
  }
  for (int i = 0; i < 4 * kSide; ++i) AddSegment(border[i], border[(i + 1) % (4 * kSide)], 0);
  box_only_ = true;
}

template <template <class> class E>
void Refinement<E>::Reserve(std::size_t points) {
  const std::size_t vertices = 2 * points;
  vertices_.reserve(vertices);
  if (triangulation_ != nullptr) triangulation_->Reserve(vertices);
  if constexpr (kTraced) {
    tree_.Reserve(vertices);
    engine_.Reserve(2 * vertices);
  }
}

template <template <class> class E>
VertexIndex Refinement<E>::AddPoint(const Point2& p, FeatureSlot feature) {
  const VertexIndex v = NewVertex();
  Vertex& vertex = vertices_[v];
  vertex.p = p;
  vertex.birth = engine_.beginning();
  vertex.feature = feature;
  vertex.dimension = 0;
  vertex.present = true;
  ++vertex_count_;
  MarkChanged(v);
  if (kTraced && triangulation_ == nullptr) appeared_.push_back(v);
  if (!is_global() || !box_only_) tree_.Insert(v, p);
  if (triangulation_ != nullptr && !triangulation_->Contains(v)) {
    triangulation_->Insert(v, p, near_);
    near_ = v;
  }
  if constexpr (kTraced) {
    NotifyOfVertex(v, true, engine_.beginning());
    engine_.Request(kNearest, v, NearestEpoch());
  } else if (triangulation_ == nullptr) {
    engine_.Request(kNearest, v, NearestEpoch());
  }
  return v;
}

template <template <class> class E>
void Refinement<E>::RemovePoint(VertexIndex v) {
  if constexpr (kTraced) {
    engine_.Unrequest(kNearest, v, NearestEpoch());
    WithdrawVertex(v, engine_.beginning());
    released_vertices_.push_back(v);
  }
}

template <template <class> class E>
SubsegmentIndex Refinement<E>::AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature,
                                          const SegmentShape& shape) {
  if (is_global() && box_only_ && feature != 0) {
    // The tree was not needed so far; subsegments are found through it.
    for (VertexIndex v = 0; v < vertices_.size(); ++v) tree_.Insert(v, vertices_[v].p);
  }
  if (feature != 0) box_only_ = false;
  const SubsegmentIndex s = NewSubsegment();
  Subsegment& sub = subsegments_[s];
  // One direction whatever the client's, so that rounding and hashes agree.
  const bool forward = vertices_[a].p < vertices_[b].p;
  sub.a = sub.whole_a = forward ? a : b;
  sub.b = sub.whole_b = forward ? b : a;
  sub.piece = Piece::Whole(shape, LengthOf(vertices_[a].p, vertices_[b].p));
  sub.feature = feature;
  engine_.Request(kCheck, s, FirstCheckEpoch());
  return s;
}

template <template <class> class E>
void Refinement<E>::RemoveSegment(SubsegmentIndex s) {
  if constexpr (kTraced) {
    engine_.Unrequest(kCheck, s, FirstCheckEpoch());
    released_subsegments_.push_back(s);
  }
}

template <template <class> class E>
SizingField::Index Refinement<E>::AddSizing(const SizingRegion& region) {
  const SizingField::Index index = sizing_.Add(region);
  NotifyOfSizing(region);
  return index;
}

template <template <class> class E>
void Refinement<E>::RemoveSizing(SizingField::Index index) {
  NotifyOfSizing(sizing_[index]);
  sizing_.Remove(index);
}

// --- For the engine ---------------------------------------------------------------------

template <template <class> class E>
std::uint64_t Refinement<E>::Priority(sac::Kind kind, sac::Item item) const {
  if (kind <= kComplete) return geometry::HashOf(vertices_[item].p);
  return geometry::Mix(HashOfSubsegment(subsegments_[item]) + kind);
}

template <template <class> class E>
std::uint64_t Refinement<E>::HashOfSubsegment(const Subsegment& s) const {
  return geometry::HashOf(vertices_[s.a].p) + 3 * geometry::HashOf(vertices_[s.b].p);
}

template <template <class> class E>
bool Refinement<E>::Before(sac::Kind kind_a, sac::Item a, sac::Kind kind_b, sac::Item b) const {
  if (kind_a != kind_b) return kind_a < kind_b;
  if (kind_a <= kComplete) return vertices_[a].p < vertices_[b].p;
  const Subsegment &s = subsegments_[a], &t = subsegments_[b];
  if (vertices_[s.a].p != vertices_[t.a].p) return vertices_[s.a].p < vertices_[t.a].p;
  return vertices_[s.b].p < vertices_[t.b].p;
}

template <template <class> class E>
void Refinement<E>::Execute(Context& context) {
  switch (context.kind) {
    case kNearest:
      if (is_global() && by_edge()) return RequestFirstGaps();
      return Nearest(context);
    case kComplete:
      near_ = context.item;
      return Complete(context);
    case kCheck:
    case kRecheck:
      near_ = subsegments_[context.item].a;
      return Check(context);
    case kSplit:
      near_ = subsegments_[context.item].a;
      return Split(context);
  }
}

template <template <class> class E>
void Refinement<E>::Prefetch(sac::Kind kind, sac::Item item, int step) const {
  if (kind != kComplete) return;
  if (step == 0) __builtin_prefetch(&vertices_[item]);
  if (triangulation_ != nullptr) triangulation_->PrefetchAround(item, step);
}

// --- Untraced and global: only vertices that own a gap are ever queued ------------------

// Once the input's subsegments are settled all gaps there are get looked for at once,
// triangle by triangle; later ones when their owner, the newborn, is published. Segment
// work of bucket 0 comes first: this is asked for through Nearest, the last step of that
// bucket.
template <template <class> class E>
void Refinement<E>::BeginUntraced() {
  if (triangulation_ != nullptr && by_edge()) {
    engine_.Request(kNearest, 0, NearestEpoch());
  } else if (triangulation_ != nullptr) {
    for (VertexIndex v = 0; v < vertices_.size(); ++v) engine_.Request(kNearest, v, NearestEpoch());
  }
}

// The bucket of edge pq if it has a gap on the side of c, (p, q, c) counter-clockwise, else
// kBuckets. d, if there is one, is the apex on the other side.
template <template <class> class E>
int Refinement<E>::BucketOfGap(VertexIndex p, VertexIndex q, VertexIndex c, VertexIndex d) const {
  constexpr VertexIndex kInfinite = mesh::DelaunayTriangulation::kInfinite;
  if (c == kInfinite) return kBuckets;  // beyond the border
  const auto at = [&](VertexIndex v) { return &triangulation_->position(v); };
  const double e2 = geometry::SquaredDistance(*at(p), *at(q));
  const Gap gap = GapOf(p, *at(p), q, *at(q), e2, c, at(c), d == kInfinite ? nullptr : at(d));
  return gap == Gap::kNone ? kBuckets : BucketOf(e2);
}

template <template <class> class E>
void Refinement<E>::RequestFirstGaps() {
  if (std::exchange(looked_for_gaps_, true)) return;
  std::vector<std::uint16_t> first(vertices_.size(), kBuckets);
  triangulation_->ForEachTriangle([&](auto t) {
    const auto& v = triangulation_->vertices(t);
    for (int i = 0; i < 3; ++i) {
      const VertexIndex p = v[triangulation_->NextIndex(i)],
                        q = v[triangulation_->PreviousIndex(i)];
      // Whether something is beyond the edge's other side is seldom asked for.
      if (BucketOfGap(p, q, v[i], mesh::DelaunayTriangulation::kInfinite) == kBuckets) continue;
      const auto across = triangulation_->Opposite({t, i});
      const int bucket =
          BucketOfGap(p, q, v[i], triangulation_->vertices(across.triangle)[across.index]);
      auto& owners = first[IsOlder(vertices_[p], vertices_[q]) ? q : p];
      owners = std::min(owners, static_cast<std::uint16_t>(bucket));
    }
  });
  for (VertexIndex v = 0; v < first.size(); ++v) {
    if (first[v] < kBuckets) {
      engine_.Request(kComplete, v, MakeEpoch(first[v], 0, kQualityStep));
    }
  }
}

// v was inserted just now, by the Complete of near_, and so owns all its edges.
template <template <class> class E>
void Refinement<E>::RequestFirstGap(VertexIndex v) {
  const auto fan = triangulation_->created();
  int first = kBuckets;
  VertexIndex right = triangulation_->vertices(fan.back())[0];
  for (const auto t : fan) {
    const VertexIndex u = triangulation_->vertices(t)[0], left = triangulation_->vertices(t)[1];
    if (u != mesh::DelaunayTriangulation::kInfinite) {
      first = std::min({first, BucketOfGap(v, u, left, right), BucketOfGap(u, v, right, left)});
    }
    right = u;
  }
  if (first == kBuckets) return;
  engine_.Request(kComplete, v, NoEarlierThan(vertices_[v].epoch, near_, v, first));
}

// --- Memory and audit ---------------------------------------------------------------------

template <template <class> class E>
std::size_t Refinement<E>::trace_bytes() const {
  if constexpr (kTraced) return engine_.bytes() + exposures_.bytes();
  return 0;
}

template <template <class> class E>
std::size_t Refinement<E>::bytes() const {
  return vertices_.size() * sizeof(Vertex) + subsegments_.capacity() * sizeof(Subsegment) +
         tree_.bytes() + sizing_.bytes();
}

template <template <class> class E>
std::uint64_t Refinement<E>::Audit(std::vector<std::string>* problems) const {
  if constexpr (!kTraced) {
    return 0;
  } else {
    const auto mix = [](std::uint64_t h, std::uint64_t x) { return geometry::Mix(h ^ x); };
    const auto hash_item = [&](sac::Kind kind, sac::Item item) {
      return mix(Priority(kind, item), kind);
    };
    const auto hash_vertex = [&](std::uint32_t id) {
      if (Star::IsGhost(id)) return static_cast<std::uint64_t>(id);
      const Vertex& v = vertices_[id];
      return mix(geometry::HashOf(v.p), v.epoch);
    };
    std::uint64_t made = 0;
    const auto hash_op = [&](sac::OpId op) {
      const Payload& payload = engine_.payload(op);
      std::uint64_t h = mix(std::bit_cast<std::uint32_t>(payload.radius2), payload.flag);
      h = mix(mix(mix(mix(h, payload.west), payload.east), payload.south), payload.north);
      std::uint64_t sum = 0;
      for (const sac::Output o : engine_.outputs(op)) {
        const std::uint32_t i = IndexOf(o);
        if (WhatOf(o) == Made::kVertex) {
          const Vertex& v = vertices_[i];
          ++made;
          if (!v.present) problems->push_back("an operation's vertex is not present");
          if (v.birth != engine_.stamp(op)) problems->push_back("a vertex's birth is another's");
          sum += mix(hash_vertex(i), v.ordinal + 256u * v.dimension);
        } else {
          sum += mix(HashOfSubsegment(subsegments_[i]), o & 3);
        }
      }
      h = mix(h, sum);
      if (engine_.kind(op) != kComplete) return h;  // witnesses may be any
      const auto ring = engine_.reads(op);
      std::uint64_t cycle = 0;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        cycle += mix(hash_vertex(ring[i]), hash_vertex(ring[(i + 1) % ring.size()]) * 3);
        if (!Star::IsGhost(ring[i]) && !vertices_[ring[i]].present) {
          problems->push_back("an operation has read a vertex that is gone");
        }
      }
      return mix(h, cycle);
    };
    const std::uint64_t hash = engine_.Audit(hash_item, hash_op, problems);
    std::size_t present = 0, inputs = 0;
    for (const Vertex& v : vertices_) {
      present += v.present;
      inputs += v.present && v.dimension == 0;
    }
    if (present != vertex_count_) problems->push_back("vertices present are not those counted");
    if (present != made + inputs) problems->push_back("a vertex is present that nobody made");
    return hash;
  }
}

template class Refinement<sac::Engine>;
template class Refinement<sac::UntracedEngine>;

}  // namespace dynmesh::meshing
