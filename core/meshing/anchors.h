// Anchors: vertices that areas with a target length and their surroundings have from the beginning.
// They are points of a lattice (anchor_lattice.h). Refinement fills the rest, between anchors and
// features.
//
// Without anchors the position of a vertex would depend on its neighbours alone, and an edit would
// propagate from vertex to vertex across the whole area, or all around it. A region has its own
// lattice and, from its border outwards, lattices that are one, two, three ... octaves wider, each
// as far as its Reach. Where several regions reach, the finest lattice counts. Its point is an
// anchor if
//   no point is nearer than kClear spacings, in 3D no edge of a facet and no side of the domain,
//   either,
//   no segment that stays whole has it in its diametral ball,
//   nothing else is nearer than kClearOfOthers spacings: other segments, in 2D the sides of the
//   domain, in 3D facets, and finer lattices that are not nested.
// This is a function of the regions and features near the point. So an edit decides again only the
// points that it may affect. Anchors stand outside the time of the trace, as the input does: an
// anchor is born with the input, lies on no feature and has no owner.
#ifndef DYNMESH_CORE_MESHING_ANCHORS_H_
#define DYNMESH_CORE_MESHING_ANCHORS_H_

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/functional/function_ref.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/anchor_lattice.h"
#include "core/meshing/complex.h"
#include "core/meshing/input_editor.h"

namespace dynmesh::meshing {

// The distance of anchors from points, in spacings of their lattice. In 2D 0.3 takes 5 % more
// vertices where points are as dense as the target.
inline constexpr double kClear = 0.6;
// The same from what is long or wide, and from other lattices: the width of the seam between them.
// With 0.6 the seam had room for a row (3D: a sheet) of vertices that depend on each other, and an
// edit propagated along all of it: beside a straight wall thousands of vertices changed, now 31.
// With 0.2 angles are smaller, and there are more vertices. Facets have anchors of their own
// (facet_anchors.h).
inline constexpr double kClearOfOthers = 0.3;
// From the domain's sides.
template <int D>
inline constexpr double kClearOfSides = D == 2 ? kClearOfOthers : kClear;

template <int D, template <class> class E>
class Anchors {
 public:
  using Point = geometry::Point<D>;
  using Lattice = AnchorLattice<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  Anchors(const Complex<D, E>& complex, InputEditor<D, E>& input)
      : complex_(complex), input_(input), widest_level_(WidestLevel(complex)) {}

  // Decides again the anchors that changes since the last propagation may affect. False if it was
  // interrupted: then the rest remains to be decided.
  bool Update(absl::FunctionRef<bool()> interrupt);
  // Balls of lattice points, and points, that were looked at because of sizes so far.
  std::uint64_t visited_nodes() const { return visited_nodes_; }
  std::size_t bytes() const {
    return anchors_.capacity() * (sizeof(typename decltype(anchors_)::value_type) + 1);
  }

 private:
  using SizeChange = typename SizeChanges<D>::Change;

  // This lattice has a point or two along the domain.
  static int WidestLevel(const Complex<D, E>& complex);
  // No lattice is finer than vertices may be.
  bool IsInUse(int level) const;
  // Calls f(level) for the lattices of a region of level `own` until f returns false. Returns false
  // if it did.
  template <class F>
  bool ForEachLevel(int own, F f) const;
  std::set<int> LevelsInUse() const;
  // With those of regions that went.
  std::set<int> LevelsOf(const SizeChanges<D>& changes) const;
  // True if all lattices that changed sizes or the present ones have are nested in each other.
  bool AreAllNested(const SizeChanges<D>& changes) const;
  // True if the change certainly has no effect on points in the ball, or at a point if radius = 0.
  // `are_nested`: AreAllNested. `reaches`: of the region's lattices, from the finest one on.
  bool IsHidden(const SizeChanges<D>& changes, const SizeChange& change, bool are_nested,
                std::span<const double> reaches, const Point& centre, double radius) const;
  static bool IsHiddenByOther(const SizeChange& change, bool are_nested,
                              std::span<const double> reaches, const Point& centre, double radius);
  // The level of the finest lattice that reaches x; more than the widest level if none does.
  int LevelAt(const Point& x) const;
  // How far anchors are from the feature, in spacings. With 0.3 from edges of facets cubes kept
  // slivers.
  double ClearOf(const InputFeature<D>& f) const;
  // `level`: the widest level that contains the point.
  bool IsAnchor(int level, const Point& x) const;
  // May `level` be the finest somewhere in the ball? Conservative: may return true needlessly.
  bool MayHaveLevel(int level, const Point& centre, double radius) const;
  void DecideAnchor(const typename Lattice::Node& node, const Point& x);

  const Complex<D, E>& complex_;
  InputEditor<D, E>& input_;
  absl::flat_hash_map<typename Lattice::Node, VertexIndex> anchors_;
  const int widest_level_;
  bool had_sizes_ = false;  // at the last Update
  std::uint64_t visited_nodes_ = 0;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
int Anchors<D, E>::WidestLevel(const Complex<D, E>& complex) {
  double side = 0;
  for (int k = 0; k < D; ++k) side = std::max(side, complex.rules.hi()[k] - complex.rules.lo()[k]);
  return Lattice::LevelOf(side / 4);
}

template <int D, template <class> class E>
bool Anchors<D, E>::IsInUse(int level) const {
  const double spacing = Lattice::Spacing(level);
  return level <= widest_level_ && spacing * spacing > 64 * complex_.rules.least_squared_length();
}

template <int D, template <class> class E>
template <class F>
bool Anchors<D, E>::ForEachLevel(int own, F f) const {
  for (int level = own; level <= widest_level_; level += Lattice::kOctave) {
    if (IsInUse(level) && !f(level)) return false;
  }
  return true;
}

template <int D, template <class> class E>
std::set<int> Anchors<D, E>::LevelsInUse() const {
  std::set<int> in_use;
  for (const auto& [own, count] : complex_.sizing.levels()) {
    ForEachLevel(own, [&](int level) { return in_use.insert(level), true; });
  }
  return in_use;
}

template <int D, template <class> class E>
std::set<int> Anchors<D, E>::LevelsOf(const SizeChanges<D>& changes) const {
  std::set<int> levels = LevelsInUse();
  for (const SizeChange& change : changes.list()) {
    ForEachLevel(Lattice::LevelOf(change.region.target),
                 [&](int level) { return levels.insert(level), true; });
  }
  return levels;
}

template <int D, template <class> class E>
bool Anchors<D, E>::AreAllNested(const SizeChanges<D>& changes) const {
  if (changes.empty()) return true;
  const int one = Lattice::LevelOf(changes.list().front().region.target);
  const auto is_nested = [&](int level) { return Lattice::AreNested(one, level); };
  return std::ranges::all_of(
             complex_.sizing.levels(),
             [&](const auto& level_and_count) { return is_nested(level_and_count.first); }) &&
         std::ranges::all_of(changes.list(), [&](const SizeChange& change) {
           return is_nested(Lattice::LevelOf(change.region.target));
         });
}

// A region has an effect at a point if its lattice there is finer than that of all others, or if it
// is not nested in theirs and its finer lattice is near (IsAnchor). How near depends on the others'
// spacing, which is at most that of the level that they have everywhere in the ball.
template <int D, template <class> class E>
bool Anchors<D, E>::IsHidden(const SizeChanges<D>& changes, const SizeChange& change,
                             bool are_nested, std::span<const double> reaches, const Point& centre,
                             double radius) const {
  if (change.other != nullptr && change.region.shape == nullptr && change.other->shape == nullptr) {
    if (IsHiddenByOther(change, are_nested, reaches, centre, radius)) return true;
    // To decide a point takes no longer than to find out more.
    if (radius == 0 || changes.IsMoveAlone(change)) return false;
  }
  const int level = changes.LevelOver(change, centre, radius, widest_level_ + 1);
  if (level > widest_level_) return false;
  const double margin =
      radius + (are_nested ? 0 : kClearOfOthers * Lattice::Spacing(level) * kBarelyWider);
  return change.region.LevelNear(centre, margin, level) >= level;
}

// The same for the region alone that takes its place or gave it its place, which has the same
// lattices: the distances from the two say which of them count. Fast. REQUIRES: there is that
// region, and both are boxes with a radius, without a shape.
template <int D, template <class> class E>
bool Anchors<D, E>::IsHiddenByOther(const SizeChange& change, bool are_nested,
                                    std::span<const double> reaches, const Point& centre,
                                    double radius) {
  const double from_this = change.region.DistanceToBox(centre),
               from_other = change.other->DistanceToBox(centre);
  const double rounding = 1e-9 * (std::fabs(from_this) + std::fabs(from_other) +
                                  change.region.radius + change.other->radius);
  const auto counts = std::ranges::lower_bound(reaches, from_other + radius + rounding);
  if (counts == reaches.end()) return false;
  if (counts == reaches.begin()) return true;
  const double spacing = *counts / Lattice::MostReach(0) * Lattice::Spacing(0);
  const double margin = are_nested ? 0 : kClearOfOthers * spacing * kBarelyWider;
  return *(counts - 1) < from_this - radius - rounding - margin;
}

template <int D, template <class> class E>
int Anchors<D, E>::LevelAt(const Point& x) const {
  return complex_.sizing.FinestLevel(x, 0, widest_level_ + 1);
}

template <int D, template <class> class E>
double Anchors<D, E>::ClearOf(const InputFeature<D>& f) const {
  if (f.a == f.b) return kClear;
  if constexpr (D == 3) {
    if (complex_.facets.HasEdge(f.a, f.b)) return kClear;
  }
  return kClearOfOthers;
}

template <int D, template <class> class E>
bool Anchors<D, E>::IsAnchor(int level, const Point& x) const {
  const int finest = LevelAt(x);
  if (finest > level || !Lattice::AreNested(finest, level) || !IsInUse(finest)) return false;
  const double spacing = Lattice::Spacing(finest), most = kClear * spacing,
               of_sides = kClearOfSides<D> * spacing;
  for (int k = 0; k < D; ++k) {
    if (!(complex_.rules.lo()[k] + of_sides <= x[k] && x[k] <= complex_.rules.hi()[k] - of_sides)) {
      return false;
    }
  }
  const auto is_other = [&](const SizingRegion<D>& region) {
    return !Lattice::AreNested(Lattice::LevelOf(region.target), finest);
  };
  if (complex_.sizing.HasFinerLevel(x, kClearOfOthers * spacing, finest, is_other)) return false;
  if (!complex_.unsplit.empty() && IsOn(RefinementTerm::kAnchorsKeepOut) &&
      complex_.unsplit.Hold(x)) {
    return false;
  }
  bool is_clear = true;
  double reach2 = most * most;
  complex_.features.VisitNear(
      x, reach2, {complex_.features.kNone, complex_.features.kNone},
      [](const Point&, double) { return true; },
      [&](const InputFeature<D>& f) {
        const double clear = ClearOf(f) * spacing;
        if (!(geometry::SquaredDistance(x, f.p, f.q) < clear * clear)) return;
        is_clear = false;
        reach2 = 0;
      });
  if constexpr (D == 3) {
    if (is_clear && !complex_.facets.empty()) {
      complex_.facets.ForEachNear(x, kClearOfOthers * spacing,
                                  [&](const Facet&) { is_clear = false; });
    }
  }
  return is_clear;
}

template <int D, template <class> class E>
bool Anchors<D, E>::Update(absl::FunctionRef<bool()> interrupt) {
  const auto& changes = input_.changes();
  int decided = 0;
  const auto sometimes = [&] { return (++decided & 255) == 0 && interrupt(); };
  // Decides the points of `level` within `margin` of the box, in balls for which is_near is true.
  const auto decide_in = [&](int level, const Extent<D>& box, double margin, auto is_near) {
    const Lattice lattice(level);
    Extent<D> within;
    for (int k = 0; k < D; ++k) {
      within.lo[k] = std::max(box.lo[k] - margin, complex_.rules.lo()[k]);
      within.hi[k] = std::min(box.hi[k] + margin, complex_.rules.hi()[k]);
    }
    return lattice.ForEachIn(within, is_near,
                             [&](const typename Lattice::Index& index, const Point& x) {
                               if (is_near(x, 0)) DecideAnchor(Lattice::NodeOf(level, index), x);
                               return !sometimes();
                             });
  };
  std::set<int> in_use = LevelsInUse();
  // Where a region that came has an effect, points of lattices of those that went may be anchors.
  const std::set<int> of_changes = LevelsOf(changes.sizes);
  const bool are_nested = AreAllNested(changes.sizes);
  for (const SizeChange& change : changes.sizes.list()) {
    const SizingRegion<D>& region = change.region;
    if (changes.sizes.IsHidden(change, [&](const SizingRegion<D>& other) {
          return Lattice::AreNested(Lattice::LevelOf(other.target),
                                    Lattice::LevelOf(region.target));
        })) {
      continue;
    }
    const bool may_be_hidden = changes.sizes.MayBeHidden(change);
    std::vector<double> reaches;
    for (int level = Lattice::LevelOf(region.target); level <= widest_level_;
         level += Lattice::kOctave) {
      reaches.push_back(Lattice::Reach(Lattice::LevelOf(region.target), level));
    }
    const auto is_hidden = [&](const Point& centre, double radius) {
      ++visited_nodes_;
      return may_be_hidden && IsHidden(changes.sizes, change, are_nested, reaches, centre, radius);
    };
    const Extent<D> box = region.Box();
    const int own = Lattice::LevelOf(region.target);
    double finer = -1;  // Reach of the lattice that is an octave finer; it contains the points
                        // within that reach.
    const bool done = ForEachLevel(own, [&](int level) {
      const double reach = Lattice::Reach(own, level);
      const auto is_near = [&](const Point& centre, double radius) {
        return region.Meets(centre, reach + radius) &&
               !(finer >= radius && region.Meets(centre, finer - radius)) &&
               !is_hidden(centre, radius);
      };
      const bool all = decide_in(level, box, reach, is_near);
      finer = reach;
      return all;
    });
    if (!done) return false;
    // Wider lattices keep a distance from the finer one beside them.
    for (const int level : of_changes) {
      if (level <= own || Lattice::AreNested(level, own)) continue;
      const int beside = own + (level - own) / Lattice::kOctave * Lattice::kOctave;
      const double margin = Lattice::Reach(own, beside) + kClearOfOthers * Lattice::Spacing(level);
      const auto is_near = [&](const Point& centre, double radius) {
        return region.Meets(centre, margin + radius) &&
               complex_.sizing.HasFinerLevel(centre, radius, level + 1) &&
               !is_hidden(centre, radius);
      };
      if (!decide_in(level, box, margin, is_near)) return false;
    }
  }
  // If there were no sizes before, every point has been decided above.
  if (!std::exchange(had_sizes_, !complex_.sizing.empty())) in_use.clear();
  // `spacings`: how near a feature or a facet may be to matter.
  const auto decide_near = [&](int level, const Extent<D>& box, double spacings, auto meets) {
    const double clear = spacings * Lattice::Spacing(level);
    return decide_in(level, box, clear, [&](const Point& centre, double radius) {
      return meets(centre, clear + radius) && MayHaveLevel(level, centre, radius);
    });
  };
  // Of a segment that stays whole: its diametral ball.
  const auto decide_in_ball = [&](int level, const InputFeature<D>& f) {
    const Point middle = geometry::Midpoint(f.p, f.q);
    const double ball_radius = 0.5 * std::sqrt(geometry::SquaredDistance(f.p, f.q)) * kBarelyWider;
    Extent<D> ball = Extent<D>::Nothing();
    ball.AddBall(middle, ball_radius);
    return decide_near(level, ball, 0, [&](const Point& centre, double radius) {
      const double reach = (ball_radius + radius) * kBarelyWider;
      return geometry::SquaredDistance(centre, middle) <= reach * reach;
    });
  };
  for (const auto& change : changes.features) {
    const InputFeature<D>& f = change.first;
    const auto meets = [&](const Point& centre, double radius) {
      return geometry::SquaredDistance(centre, f.p, f.q) <= radius * radius;
    };
    // In 3D it may have been an edge of a facet, or be one now.
    const double clear = D == 3 ? kClear : ClearOf(f);
    // Within kClear spacings of a point, lattices are at most an octave finer than at the point.
    const auto first =
        f.a != f.b ? in_use.begin() : in_use.lower_bound(LevelAt(f.p) - Lattice::kOctave);
    for (auto level = first; level != in_use.end(); ++level) {
      if (!decide_near(*level, BoxOf(f), clear, meets)) return false;
      if (f.unsplit && !decide_in_ball(*level, f)) return false;
    }
  }
  if constexpr (D == 3) {
    for (const Facet& facet : changes.facets) {
      const auto meets = [&](const Point& centre, double radius) {
        return facet.where().MayMeet(centre, radius);
      };
      for (const int level : in_use) {
        if (!decide_near(level, facet.where().box, kClear, meets)) return false;
      }
    }
  }
  return true;
}

template <int D, template <class> class E>
bool Anchors<D, E>::MayHaveLevel(int level, const Point& centre, double radius) const {
  return !complex_.sizing.HasFinerLevel(centre, -radius, level) &&
         complex_.sizing.HasFinerLevel(centre, radius, level + 1);
}

template <int D, template <class> class E>
void Anchors<D, E>::DecideAnchor(const typename Lattice::Node& node, const Point& x) {
  const bool is = IsAnchor(node.level, x);
  const auto at = anchors_.find(node);
  if (is == (at != anchors_.end())) return;
  if (is) {
    anchors_[node] = input_.AddAnchor(x, kNil);
  } else if constexpr (kTraced) {
    input_.RemovePoint(at->second);
    anchors_.erase(at);
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_ANCHORS_H_
