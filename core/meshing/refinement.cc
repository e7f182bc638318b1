#include "core/meshing/refinement.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <string>
#include <utility>

#include "core/meshing/anchors.h"
#include "core/meshing/changes.h"
#include "core/meshing/complete.h"
#include "core/meshing/cure.h"
#include "core/meshing/facet_anchors.h"
#include "core/meshing/facet_work.h"
#include "core/meshing/idle_star.h"
#include "core/meshing/neighbourhood.h"
#include "core/meshing/planar_gaps.h"
#include "core/meshing/segments.h"
#include "core/meshing/space_gaps.h"
#include "core/meshing/star_search.h"

namespace dynmesh::meshing {

#ifdef DYNMESH_MUTATE_FILTERS
Term switched_off = Term::kCount;
#endif

namespace {

geometry::Point3 FacetBox(const geometry::Point3& p) { return p; }
geometry::Point3 FacetBox(const geometry::Point2&) { return {}; }

}  // namespace

template <int D, template <class> class E>
Refinement<D, E>::Refinement(const MeshOptions& options, Triangulation* triangulation)
    : rules_(options),
      limits_(options.limits),
      triangulation_(triangulation),
      domain_(triangulation),
      tree_(rules_.lo(), rules_.hi()),
      sizing_(rules_.lo(), rules_.hi()),
      features_(rules_.lo(), rules_.hi()),
      facets_(FacetBox(rules_.lo()), FacetBox(rules_.hi())),
      slivers_(D == 3 ? std::max(options.min_dihedral, kFlat) : 0),
      cured_(rules_.lo(), rules_.hi()),
      engine_(*this) {
  AddBox();
  if (options.max_edge > 0) {
    SizingRegion<D> box;
    for (int k = 0; k < D; ++k) box.lo[k] = options.box.lo[k], box.hi[k] = options.box.hi[k];
    box.target = options.max_edge;
    sizing_.Add(box);
    AddSize(box);
  }
}

// --- Input ----------------------------------------------------------------------------

template <int D, template <class> class E>
void Refinement<D, E>::ResetToDomain(Triangulation* triangulation) const {
  std::array<VertexIndex, 1 << D> corners;
  for (VertexIndex v = 0; v < corners.size(); ++v) corners[v] = v;
  triangulation->Reset(rules_.lo(), rules_.hi(), corners);
}

template <int D, template <class> class E>
void Refinement<D, E>::AddBox() {
  if (triangulation_ != nullptr) ResetToDomain(triangulation_);
  if constexpr (D == 2) {
    AddSquare();
  } else {
    AddCube();
  }
  box_only_ = true;
}

// 24 points, counter-clockwise, the corners first (a triangulation begins with them).
template <int D, template <class> class E>
void Refinement<D, E>::AddSquare() {
  if constexpr (D == 2) {
    constexpr int kSide = 6;
    const Point &lo = rules_.lo(), &hi = rules_.hi();
    const double step = rules_.grid_spacing();
    std::array<VertexIndex, 4 * kSide> border;
    const auto at = [&](int side, int i) -> Point {
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
    for (int side = 0; side < 4; ++side) border[side * kSide] = AddPoint(at(side, 0), 0);
    for (int side = 0; side < 4; ++side) {
      near_ = border[side * kSide];
      for (int i = 1; i < kSide; ++i) border[side * kSide + i] = AddPoint(at(side, i), 0);
    }
    for (int i = 0; i < 4 * kSide; ++i) AddSegment(border[i], border[(i + 1) % (4 * kSide)], 0);
  }
}

// A grid of points on the six sides, the corners first.
template <int D, template <class> class E>
void Refinement<D, E>::AddCube() {
  if constexpr (D == 3) {
    const int cells = rules_.grid_cells();
    const double step = rules_.grid_spacing();
    const auto at = [&](int axis, int i) {
      return i == cells ? rules_.hi()[axis] : rules_.lo()[axis] + i * step;
    };
    const auto add = [&](int i, int j, int k) { AddPoint({{at(0, i), at(1, j), at(2, k)}}, 0); };
    for (int m = 0; m < 8; ++m) add(m & 1 ? cells : 0, m & 2 ? cells : 0, m & 4 ? cells : 0);
    for (int i = 0; i <= cells; ++i) {
      for (int j = 0; j <= cells; ++j) {
        for (int k = 0; k <= cells; ++k) {
          const int sides = (i % cells == 0) + (j % cells == 0) + (k % cells == 0);
          if (sides == 1 || sides == 2) add(i, j, k);
        }
      }
    }
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::Reserve(std::size_t points) {
  const std::size_t vertices = 2 * points;
  vertices_.reserve(vertices);
  if (triangulation_ != nullptr) triangulation_->Reserve(vertices);
  if constexpr (kTraced) {
    tree_.Reserve(vertices);
    engine_.Reserve(2 * vertices, D == 2 ? 16 : 24);
  }
}

template <int D, template <class> class E>
VertexIndex Refinement<D, E>::AddPoint(const Point& p, FeatureSlot feature) {
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
  if (indexes_features_ && feature != kNil) AddFeature(FeatureOf(v, v));
  if constexpr (D == 2) {
    if (triangulation_ != nullptr && !triangulation_->Contains(v)) {
      triangulation_->Insert(v, p, near_);
      near_ = v;
    }
  } else {
    if (triangulation_ != nullptr && !triangulation_->Contains(v)) pending_.push_back(v);
  }
  if constexpr (kTraced) {
    NotifyOfVertex(v, true, engine_.beginning());
    engine_.Request(kNearest, v, NearestEpoch());
  } else if (triangulation_ == nullptr) {
    engine_.Request(kNearest, v, NearestEpoch());
  }
  return v;
}

template <int D, template <class> class E>
void Refinement<D, E>::RemovePoint(VertexIndex v) {
  if constexpr (kTraced) {
    if (indexes_features_) RemoveFeature(FeatureOf(v, v));
    engine_.Unrequest(kNearest, v, NearestEpoch());
    WithdrawVertex(v, engine_.beginning());
    released_vertices_.push_back(v);
  }
}

template <int D, template <class> class E>
SubsegmentIndex Refinement<D, E>::AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature,
                                             const SegmentShape& shape) {
  if (is_global() && box_only_ && feature != 0) {
    // So far nothing needed the tree. Subsegments are found through it.
    for (VertexIndex v = 0; v < vertices_.size(); ++v) tree_.Insert(v, vertices_[v].p);
  }
  if (feature != 0) {
    box_only_ = false;
    IndexFeatures();
  }
  const SubsegmentIndex s = NewSubsegment();
  Subsegment& sub = subsegments_[s];
  // The direction does not depend on the client's, so that rounding and hashes agree.
  const bool forward = vertices_[a].p < vertices_[b].p;
  sub.a = sub.whole_a = forward ? a : b;
  sub.b = sub.whole_b = forward ? b : a;
  if constexpr (D == 2) {
    sub.piece = Piece::Whole(shape, LengthOf(vertices_[a].p, vertices_[b].p));
  }
  sub.feature = feature;
  // No feature is near the sides of the domain (DomainBox).
  if (feature == 0) {
    engine_.Request(kCheck, s, FirstCheckEpoch());
  } else {
    AddFeature(FeatureOf(sub.a, sub.b));
    engine_.Request(kPresplit, s, PresplitEpoch());
  }
  return s;
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveSegment(SubsegmentIndex s) {
  if constexpr (kTraced) {
    RemoveFeature(FeatureOf(subsegments_[s].a, subsegments_[s].b));
    engine_.Unrequest(kPresplit, s, PresplitEpoch());
    released_subsegments_.push_back(s);
  }
}

template <int D, template <class> class E>
typename SizingField<D>::Index Refinement<D, E>::AddSizing(const SizingRegion<D>& region) {
  const auto index = sizing_.Add(region);
  AddSize(region);
  NotifyOfSizing(region);
  return index;
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveSizing(typename SizingField<D>::Index index) {
  NotifyOfSizing(sizing_[index]);
  RemoveSize(sizing_[index]);
  sizing_.Remove(index);
}

// --- For the engine ---------------------------------------------------------------------

template <int D, template <class> class E>
std::uint64_t Refinement<D, E>::Priority(sac::Kind kind, sac::Item item) const {
  if (kind <= kComplete) return geometry::HashOf(vertices_[item].p);
  if (kind == kCure) return slivers_[item].hash;
  return geometry::Mix(HashOfSubsegment(subsegments_[item]) + kind);
}

template <int D, template <class> class E>
std::uint64_t Refinement<D, E>::HashOfSubsegment(const Subsegment& s) const {
  return geometry::HashOf(vertices_[s.a].p) + 3 * geometry::HashOf(vertices_[s.b].p);
}

template <int D, template <class> class E>
bool Refinement<D, E>::Before(sac::Kind kind_a, sac::Item a, sac::Kind kind_b, sac::Item b) const {
  if (kind_a != kind_b) return kind_a < kind_b;
  if (kind_a <= kComplete) return vertices_[a].p < vertices_[b].p;
  if (kind_a == kCure) {
    const auto places = [this](sac::Item item) {
      std::array<Point, 4> p;
      for (std::size_t i = 0; i < 4; ++i) p[i] = vertices_[slivers_[item].v[i]].p;
      return p;
    };
    return places(a) < places(b);
  }
  const Subsegment &s = subsegments_[a], &t = subsegments_[b];
  if (vertices_[s.a].p != vertices_[t.a].p) return vertices_[s.a].p < vertices_[t.a].p;
  return vertices_[s.b].p < vertices_[t.b].p;
}

template <int D, template <class> class E>
void Refinement<D, E>::Execute(Context& context) {
  switch (context.kind) {
    case kNearest:
      ++nearest_run_;
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
    case kPresplit:
      near_ = subsegments_[context.item].a;
      return Presplit(context);
    case kCure:
      return Cure(context);
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::Prefetch(sac::Kind kind, sac::Item item, int step) const {
  if (step == 0 && kind <= kComplete) __builtin_prefetch(&vertices_[item]);
  if (kind != kComplete) return;
  if (triangulation_ != nullptr) triangulation_->PrefetchAround(item, step);
}

// --- Untraced and global: only vertices that own a gap are ever queued ------------------

// Once the input's subsegments are settled, all present gaps are found at once, triangle by
// triangle; later gaps when their owner, the newborn, is published. The segment work of bucket 0
// comes first. So the pass is requested as a Nearest, the last step of that bucket.
template <int D, template <class> class E>
void Refinement<D, E>::BeginUntraced() {
  if (triangulation_ != nullptr && by_edge()) {
    engine_.Request(kNearest, 0, NearestEpoch());
  } else if (triangulation_ != nullptr) {
    for (VertexIndex v = 0; v < vertices_.size(); ++v) engine_.Request(kNearest, v, NearestEpoch());
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::RequestFirstGaps() {
  if (std::exchange(looked_for_gaps_, true)) return;
  std::vector<std::uint16_t> first(vertices_.size(), kBuckets);
  if constexpr (D == 2) {
    const Gaps gaps(*this);
    triangulation_->ForEachSimplex([&](auto t) {
      const auto& v = triangulation_->vertices(t);
      for (int i = 0; i < 3; ++i) {
        const VertexIndex p = v[triangulation_->NextIndex(i)],
                          q = v[triangulation_->PreviousIndex(i)];
        // The vertex beyond the edge is rarely needed.
        if (gaps.BucketOf(p, q, v[i], Triangulation::kInfinite) == kBuckets) continue;
        const auto across = triangulation_->Opposite({t, i});
        const int bucket =
            gaps.BucketOf(p, q, v[i], triangulation_->vertices(across.simplex)[across.index]);
        auto& owners = first[IsOlder(p, q) ? q : p];
        owners = std::min(owners, static_cast<std::uint16_t>(bucket));
      }
    });
  } else {
    const TetrahedronGaps gaps(*this);
    triangulation_->ForEachSimplex([&](auto t) {
      const auto& corners = triangulation_->vertices(t);
      const double r2 = gaps.MostRadius2(t);
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < i; ++j) {
          const int bucket = gaps.BucketOf(corners[i], corners[j], r2);
          if (bucket == kBuckets) continue;
          const bool older = IsOlder(corners[i], corners[j]);
          auto& owners = first[corners[older ? j : i]];
          owners = std::min(owners, static_cast<std::uint16_t>(bucket));
        }
      }
    });
  }
  for (VertexIndex v = 0; v < first.size(); ++v) {
    if (first[v] < kBuckets) {
      engine_.Request(kComplete, v, MakeEpoch(first[v], 0, kQualityStep));
    }
  }
}

// v has just been inserted by the Complete of near_, so it owns all its edges. Its first Complete
// is not before the bucket of its nearest neighbours, the vertices of the gap that it fills, as in
// a traced run. By rounding the third corner may be slightly nearer, and in an earlier bucket.
template <int D, template <class> class E>
void Refinement<D, E>::RequestFirstGap(VertexIndex v) {
  int first = kBuckets;
  const auto created = triangulation_->created();
  if constexpr (D == 2) {
    const Gaps gaps(*this);
    VertexIndex right = triangulation_->vertices(created.back())[0];
    for (const auto t : created) {
      const VertexIndex u = triangulation_->vertices(t)[0], left = triangulation_->vertices(t)[1];
      if (u != Triangulation::kInfinite) {
        first =
            std::min({first, gaps.BucketOf(v, u, left, right), gaps.BucketOf(u, v, right, left)});
      }
      right = u;
    }
  } else {
    const TetrahedronGaps gaps(*this);
    for (const auto t : created) {
      if (triangulation_->IsInfinite(t)) continue;
      const auto& corners = triangulation_->vertices(t);
      const double r2 = gaps.MostRadius2(t);
      for (int i = 0; i < 3; ++i) first = std::min(first, gaps.BucketOf(v, corners[i], r2));
    }
  }
  if (first == kBuckets) return;
  first = std::max<int>(first, gap_buckets_[vertices_[v].ordinal]);
  engine_.Request(kComplete, v, NoEarlierThan(vertices_[v].epoch, near_, v, first));
}

// --- 3D: the triangulation of the input need not be small ------------------------------

// Inserts the points added so far, in a fast order. If there are many tetrahedra per vertex, as
// between curves, refinement would make still more. Then neighbourhoods are found without a
// triangulation.
template <int D, template <class> class E>
bool Refinement<D, E>::FillTriangulation(absl::FunctionRef<bool()> interrupt) {
  if constexpr (D == 3) {
    if (triangulation_ == nullptr || pending_.empty()) return true;
    // In a triangulation gaps are found tetrahedron by tetrahedron; facets are not.
    if (!facets_.empty()) {
      LeaveTriangulation();
      return true;
    }
    constexpr std::size_t kMostPerVertex = 16, kFirst = 512, kAtOnce = 2048;
    std::vector<VertexIndex> part;
    std::vector<Point> places;
    // Random rounds, each as large as all earlier ones together: a few points show whether there
    // are too many tetrahedra. Rounds follow a hash of the rank, as coordinates are the client's
    // choice.
    const int rounds = std::bit_width(pending_.size() / kFirst);
    for (int round = rounds; round >= 0; --round) {
      part.clear();
      places.clear();
      for (std::size_t rank = 0; rank < pending_.size(); ++rank) {
        if (std::min(std::countl_zero(geometry::Mix(rank)), rounds) != round) continue;
        const VertexIndex v = pending_[rank];
        part.push_back(v);
        places.push_back(vertices_[v].p);
      }
      for (std::size_t from = 0; from < part.size(); from += kAtOnce) {
        if (interrupt()) return false;
        const std::size_t count = std::min(kAtOnce, part.size() - from);
        triangulation_->InsertAll(std::span(part).subspan(from, count),
                                  std::span(places).subspan(from, count));
      }
      if (triangulation_->is_full() ||
          triangulation_->simplex_count() >
              kMostPerVertex * triangulation_->vertex_count() + 10'000) {
        LeaveTriangulation();
        return true;
      }
    }
    pending_.clear();
  }
  return true;
}

template <int D, template <class> class E>
void Refinement<D, E>::LeaveTriangulation() {
  ResetToDomain(triangulation_);
  triangulation_ = nullptr;
  pending_.clear();
  if constexpr (!kTraced) {
    for (VertexIndex v = 0; v < vertices_.size(); ++v) {
      if (box_only_) tree_.Insert(v, vertices_[v].p);
      engine_.Request(kNearest, v, NearestEpoch());
    }
  }
}

// --- Memory and audit ---------------------------------------------------------------------

template <int D, template <class> class E>
std::size_t Refinement<D, E>::trace_bytes() const {
  if constexpr (kTraced) return engine_.bytes() + exposures_.bytes();
  return 0;
}

template <int D, template <class> class E>
std::size_t Refinement<D, E>::bytes() const {
  return vertices_.size() * sizeof(Vertex) + subsegments_.capacity() * sizeof(Subsegment) +
         tree_.bytes() + cured_.bytes() + slivers_.bytes() + sizing_.bytes() + features_.bytes() +
         facets_.bytes() +
         anchors_.capacity() * (sizeof(typename decltype(anchors_)::value_type) + 1);
}

template <int D, template <class> class E>
std::uint64_t Refinement<D, E>::Audit(std::vector<std::string>* problems,
                                      std::vector<OperationHash>* operations) const {
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
      // The payload and the reads of a Cure are not hashed: which of several reasons refused a
      // candidate is not determined.
      std::uint64_t h = 0;
      if (engine_.kind(op) != kCure) {
        h = mix(std::bit_cast<std::uint32_t>(payload.radius2), payload.flag);
        h = mix(h, payload.region());
      }
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
      if (engine_.kind(op) != kComplete) return h;  // which witnesses were read is not determined
      // The sum over the corners. It does not depend on the neighbour with which a corner begins.
      std::uint64_t corners = 0;
      ForEachCornerIn<D>(engine_.reads(op), [&](const Corner& ids) {
        for (int k = 0; k < (D == 2 ? 1 : D); ++k) {
          std::uint64_t turned = 0;
          for (int j = 0; j < D; ++j) turned = mix(turned, hash_vertex(ids[(k + j) % D]) * 3);
          corners += turned;
        }
        return true;
      });
      for (const std::uint32_t id : NeighboursIn<D>(engine_.reads(op))) {
        if (!Star::IsGhost(id) && !vertices_[id].present) {
          problems->push_back("an operation has read a vertex that is gone");
        }
      }
      return mix(h, corners);
    };
    const auto on_op = [&](sac::OpId op, std::uint64_t whole) {
      if (operations == nullptr) return;
      const std::uint64_t item = hash_item(engine_.kind(op), engine_.item(op));
      operations->push_back({mix(item, engine_.epoch(op)), whole, op});
    };
    const std::uint64_t hash = engine_.Audit(hash_item, hash_op, on_op, problems);
    std::size_t present = 0, inputs = 0;
    for (const Vertex& v : vertices_) {
      present += v.present;
      inputs += v.present && v.creator == sac::kNoOp;
    }
    if (present != vertex_count_) problems->push_back("vertices present are not those counted");
    if (present != made + inputs) problems->push_back("a vertex is present that no operation made");
    return hash;
  }
}

template <int D, template <class> class E>
std::string Refinement<D, E>::Describe(sac::OpId op) const {
  std::string text;
  if constexpr (kTraced) {
    constexpr const char* kNames[] = {"Nearest", "Complete", "Check", "Split",
                                      "Recheck", "Presplit", "Cure"};
    const auto add = [&text](const auto&... parts) { (text.append(parts), ...); };
    const auto add_vertex = [&](VertexIndex v) {
      if (Star::IsGhost(v)) return add(" ghost");
      for (int k = 0; k < D; ++k) {
        char number[32];
        std::snprintf(number, sizeof(number), "%.17g", vertices_[v].p[k]);
        add(k == 0 ? " (" : ", ", number);
      }
      add(")");
    };
    const sac::Kind kind = engine_.kind(op);
    const sac::Item item = engine_.item(op);
    add(kNames[kind], " of");
    if (kind <= kComplete) {
      add_vertex(item);
    } else if (kind == kCure) {
      for (const VertexIndex v : slivers_[item].v) add_vertex(v);
    } else {
      add_vertex(subsegments_[item].a);
      add_vertex(subsegments_[item].b);
    }
    const sac::Epoch epoch = engine_.epoch(op);
    add(", bucket ", std::to_string(BucketOfEpoch(epoch)), ", round ",
        std::to_string(RoundOfEpoch(epoch)), ", step ", std::to_string(StepOfEpoch(epoch)),
        ", made:");
    for (const sac::Output o : engine_.outputs(op)) {
      if (WhatOf(o) == Made::kVertex) {
        add_vertex(IndexOf(o));
      } else {
        const Subsegment& s = subsegments_[IndexOf(o)];
        add(" subsegment");
        add_vertex(s.a), add_vertex(s.b);
      }
    }
    if (kind == kComplete) {
      add(", read:");
      for (const std::uint32_t v : NeighboursIn<D>(engine_.reads(op))) add_vertex(v);
    } else {
      add(", words read: ", std::to_string(engine_.reads(op).size()));
    }
  }
  return text;
}

template class Refinement<2, sac::Engine>;
template class Refinement<2, sac::UntracedEngine>;
template class Refinement<3, sac::Engine>;
template class Refinement<3, sac::UntracedEngine>;

}  // namespace dynmesh::meshing
