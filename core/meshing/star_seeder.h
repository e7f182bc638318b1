// Which vertices are likely to be in a star.
#ifndef DYNMESH_CORE_MESHING_STAR_SEEDER_H_
#define DYNMESH_CORE_MESHING_STAR_SEEDER_H_

#include <algorithm>
#include <utility>
#include <vector>

#include "core/meshing/complex.h"
#include "core/meshing/star.h"
#include "core/meshing/star_reads.h"
#include "core/meshing/star_view.h"

namespace dynmesh::meshing {

// Inserts vertices that are likely to be in the star, which makes verification fast. What is
// inserted does not influence the result. Thread-compatible.
template <int D, template <class> class E>
class StarSeeder {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  using Star = meshing::Star<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  explicit StarSeeder(const Complex<D, E>& complex) : complex_(complex) {}

  // `star`: as begun, without vertices.
  void Run(const Context& context, Star& star);

 private:
  void SortByDistance(const Star& star, std::vector<std::uint32_t>* ids);
  void OfferBeyondNeighbours(const Context& context, Star& star);
  double DistanceFrom2(const Star& star, VertexIndex u) const {
    return geometry::SquaredDistance(complex_.vertex(u).p, star.position());
  }

  const Complex<D, E>& complex_;
  // Scratch.
  std::vector<VertexIndex> far_;
  std::vector<std::uint32_t> offers_;
  std::vector<std::pair<double, std::uint32_t>> by_distance_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
void StarSeeder<D, E>::Run(const Context& context, Star& star) {
  const VertexIndex v = star.vertex();
  bool newborn = false;
  offers_.clear();
  auto offer_all = [&](std::span<const std::uint32_t> ids) {
    offers_.insert(offers_.end(), ids.begin(), ids.end());
  };
  if constexpr (kTraced) {
    if (!context.first_time()) {
      offer_all(NeighboursIn<D>(context.old_reads()));
    } else {
      for (sac::OpId o = complex_.vertex(v).operations; o != sac::kNoOp;
           o = complex_.engine.next_of_item(o)) {
        if (complex_.engine.kind(o) == kComplete && complex_.engine.executed(o))
          offer_all(NeighboursIn<D>(complex_.engine.reads(o)));
      }
      const sac::OpId creator = complex_.vertex(v).creator;
      if (offers_.empty() && creator != sac::kNoOp && complex_.engine.kind(creator) == kComplete) {
        newborn = true;
        offer_all(NeighboursIn<D>(complex_.engine.reads(creator)));
        offers_.push_back(complex_.engine.item(creator));
        for (const sac::Output o : complex_.engine.outputs(creator)) offers_.push_back(IndexOf(o));
      }
    }
  }
  if (offers_.empty()) {
    // The nearest few within a little more than the lengths of this bucket; in 3D, within more if
    // these are too few. Where target lengths apply, there may be thousands.
    double r2 = 2.25 * LeastOfBucket(BucketOfEpoch(context.epoch) + 1);
    constexpr std::size_t kEnough = D == 2 ? 0 : 16, kMost = 32;
    const double most2 = 10 * r2;
    do {
      by_distance_.clear();
      double within2 = r2;
      complex_.tree.VisitBall(complex_.vertex(v).p, within2,
                              [&](std::uint32_t id, const Point&, double d2) {
                                if (id == v || !context.Sees(complex_.vertex(id).birth)) return;
                                if (by_distance_.size() == kMost) {
                                  std::pop_heap(by_distance_.begin(), by_distance_.end());
                                  by_distance_.pop_back();
                                }
                                by_distance_.emplace_back(d2, id);
                                std::push_heap(by_distance_.begin(), by_distance_.end());
                                if (by_distance_.size() == kMost)
                                  within2 = by_distance_.front().first;
                              });
      r2 *= 2;
    } while (by_distance_.size() < kEnough && r2 < most2);
    std::sort_heap(by_distance_.begin(), by_distance_.end());
    for (const auto& [d2, id] : by_distance_) offers_.push_back(id);
  } else if constexpr (D == 3) {
    SortByDistance(star, &offers_);
  }
  for (const std::uint32_t id : offers_) Offer(complex_, context, id, star);
  if (newborn) OfferBeyondNeighbours(context, star);
}

// The nearest first: then fewer temporary corners are made.
template <int D, template <class> class E>
void StarSeeder<D, E>::SortByDistance(const Star& star, std::vector<std::uint32_t>* ids) {
  by_distance_.clear();
  for (const std::uint32_t id : *ids) {
    if (IsVertexWord(id)) by_distance_.emplace_back(DistanceFrom2(star, id), id);
  }
  std::sort(by_distance_.begin(), by_distance_.end());
  by_distance_.erase(std::unique(by_distance_.begin(), by_distance_.end()), by_distance_.end());
  ids->clear();
  for (const auto& [d2, id] : by_distance_) ids->push_back(id);
}

// The creator of a newborn has seen only one side of it. What lies on the other side is in the
// rings of its neighbours there: those that still have a large corner.
template <int D, template <class> class E>
void StarSeeder<D, E>::OfferBeyondNeighbours(const Context& context, Star& star) {
  if constexpr (kTraced) {
    far_.clear();
    for (int i = 0; i < star.corner_count(); ++i) {
      for (const auto id : star.IdsOf(i)) {
        if (!Star::IsGhost(id) && star.corner(i).r2 >= 4 * DistanceFrom2(star, id))
          far_.push_back(id);
      }
    }
    std::sort(far_.begin(), far_.end());
    far_.erase(std::unique(far_.begin(), far_.end()), far_.end());
    offers_.clear();
    for (const VertexIndex u : far_) {
      sac::OpId o = complex_.vertex(u).operations;
      while (o != sac::kNoOp &&
             !(complex_.engine.kind(o) == kComplete && complex_.engine.executed(o))) {
        o = complex_.engine.next_of_item(o);
      }
      if (o == sac::kNoOp) continue;
      const auto ring = NeighboursIn<D>(complex_.engine.reads(o));
      offers_.insert(offers_.end(), ring.begin(), ring.end());
    }
    for (const std::uint32_t id : offers_) Offer(complex_, context, id, star);
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_SEEDER_H_
