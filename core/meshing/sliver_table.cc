#include "core/meshing/sliver_table.h"

#include <algorithm>
#include <cmath>

#include "core/base/mix.h"
#include "core/geometry/circumball.h"
#include "core/meshing/refinement_terms.h"

namespace dynmesh::meshing {
namespace {

// A tetrahedron's corners, sorted by position. is_odd: sorting reversed its orientation.
struct Corners {
  std::array<VertexIndex, 4> v;
  std::array<geometry::Point3, 4> p;
  bool is_odd = false;

  Corners(const std::array<VertexIndex, 4>& corners,
          const delaunay::DelaunayTetrahedralization& base)
      : v(corners) {
    for (std::size_t i = 0; i < 4; ++i) p[i] = base.position(v[i]);
    Sort();
  }
  Corners(const std::array<VertexIndex, 4>& corners, const std::array<geometry::Point3, 4>& at)
      : v(corners), p(at) {
    Sort();
  }

 private:
  void Sort() {
    const auto sort = [this](std::size_t i, std::size_t j) {
      if (!(p[j] < p[i])) return;
      std::swap(p[i], p[j]), std::swap(v[i], v[j]);
      is_odd = !is_odd;
    };
    sort(0, 1), sort(2, 3), sort(0, 2), sort(1, 3), sort(1, 2);
  }
};

void SetBall(const Corners& corners, Sliver* sliver) {
  const auto& [p, q, r, t] = corners.p;
  sliver->shortest2 = std::min({geometry::SquaredDistance(p, q), geometry::SquaredDistance(p, r),
                                geometry::SquaredDistance(p, t), geometry::SquaredDistance(q, r),
                                geometry::SquaredDistance(q, t), geometry::SquaredDistance(r, t)});
  const geometry::Circumball ball =
      corners.is_odd ? geometry::CircumballOf(p, q, t, r) : geometry::CircumballOf(p, q, r, t);
  for (int k = 0; k < 3; ++k) sliver->centre[k] = p[k] + ball.w[static_cast<std::size_t>(k)];
  sliver->radius = std::sqrt(ball.r2);
}

// The normal of the two opposite edges that span most: the diagonals, if it looks like a square.
void SetNormal(const Corners& corners, Sliver* sliver) {
  const auto& p = corners.p;
  double most2 = 0;
  const auto offer = [&](std::size_t i, std::size_t j, std::size_t k, std::size_t l) {
    const geometry::Vector3 n =
        geometry::Cross(geometry::Difference(p[j].c, p[i].c), geometry::Difference(p[l].c, p[k].c));
    const double n2 = geometry::Dot(n, n);
    if (!(n2 > most2)) return;
    most2 = n2;
    const double length = std::sqrt(n2);
    for (std::size_t a = 0; a < 3; ++a) sliver->normal[a] = n[a] / length;
  };
  offer(0, 1, 2, 3), offer(0, 2, 1, 3), offer(0, 3, 1, 2);
}

}  // namespace

bool SliverTable::Begin(const Base& whole, bool is_to_change, IsExcused is_excused, IsFlat is_flat,
                        absl::FunctionRef<bool()> interrupt) {
  constexpr std::uint32_t kAtOnce = 4096;
  if (is_to_change) own_.Copy(whole);
  base_ = is_to_change ? &own_ : &whole;
  for (std::uint32_t t = 0; t < base_->simplex_limit(); ++t) {
    if (t % kAtOnce == 0 && interrupt()) return false;
    if (base_->IsInfinite(t) || IsOutside(t)) continue;
    if (is_to_change) own_.set_tag(t, 0);
    Look(t, is_excused, is_flat);
  }
  return true;
}

void SliverTable::Remove(VertexIndex v) {
  own_.Remove(v);
  RecordChanges();
}

void SliverTable::Insert(VertexIndex v, const Point& p, VertexIndex near) {
  own_.Insert(v, p, near);
  RecordChanges();
}

// The tag of a tetrahedron is its sliver + 1, or 0.
void SliverTable::RecordChanges() {
  for (const std::uint64_t tag : own_.deleted_tags()) {
    if (tag == 0) continue;
    const auto i = static_cast<SliverIndex>(tag - 1);
    slivers_[i].is_there = false;
    auto key = slivers_[i].v;
    std::sort(key.begin(), key.end());
    leaving_[key] = i;
    Touch(i);
  }
  const auto created = own_.created();
  fresh_.insert(fresh_.end(), created.begin(), created.end());
}

void SliverTable::FindSlivers(IsExcused is_excused, IsFlat is_flat) {
  // Some were deleted again, some indices were used twice.
  std::sort(fresh_.begin(), fresh_.end());
  fresh_.erase(std::unique(fresh_.begin(), fresh_.end()), fresh_.end());
  for (const std::uint32_t t : fresh_) {
    if (!own_.IsInfinite(t)) Look(t, is_excused, is_flat);
  }
  fresh_.clear();
}

namespace {

bool IsBelow(const geometry::DihedralBound& bound, const Corners& corners,
             SliverTable::IsExcused is_excused) {
  if (!bound.IsBelowSorted(corners.p)) return false;
  return bound.IsBelowSorted(corners.p, [&](int i, int j) {
    const VertexIndex v = corners.v[static_cast<std::size_t>(i)],
                      u = corners.v[static_cast<std::size_t>(j)];
    return v != kNil && u != kNil && is_excused(v, u);
  });
}

// The tetrahedra at a short edge have angles of its length beside their size. If it is a sixth of
// the radius or less, a candidate that makes them good would be nearer to it than any is. Up to a
// fifth one in four has such a candidate, and the others take half of the time of all.
bool IsHopeless(const Corners& corners) {
  constexpr double kLeastEdge = 0.2;  // in radii
  Sliver sliver;
  SetBall(corners, &sliver);
  return !(sliver.shortest2 > kLeastEdge * kLeastEdge * (sliver.radius * sliver.radius));
}

}  // namespace

bool SliverTable::IsSliver(std::array<VertexIndex, 4> v, std::array<Point, 4> p,
                           IsExcused is_excused) const {
  using Certain = geometry::DihedralBound::Certain;
  const Certain certain = bound_.Look(p, [&](int i, int j) {
    return v[static_cast<std::size_t>(i)] == kNil || v[static_cast<std::size_t>(j)] == kNil;
  });
  if (certain != Certain::kUnsure) return certain == Certain::kOne;
  return IsBelow(bound_, Corners(v, p), is_excused);
}

geometry::DihedralBound::Certain SliverTable::Look(const std::array<Point, 4>& p) const {
  return bound_.Look(p, [](int i, int) { return i == 3; });
}

void SliverTable::Look(std::uint32_t simplex, IsExcused is_excused, IsFlat is_flat) {
  const Corners corners(base_->vertices(simplex), *base_);
  if (!bound_.IsBelowSorted(corners.p)) return;
  const bool is_exempt = !IsBelow(bound_, corners, is_excused) || is_flat(corners.v);
  if (is_exempt && (!IsOn(RefinementTerm::kExemptAreCured) || IsHopeless(corners))) return;
  const SliverIndex i = Find(corners.v);
  Sliver& sliver = slivers_[i];
  sliver.v = corners.v;
  sliver.simplex = simplex;
  sliver.is_exempt = is_exempt;
  sliver.is_there = true;
  sliver.hash = 0;
  for (const Point& p : corners.p) sliver.hash = Mix(sliver.hash ^ geometry::HashOf(p));
  SetBall(corners, &sliver);
  SetNormal(corners, &sliver);
  if (base_ == &own_) own_.set_tag(simplex, std::uint64_t{i} + 1);
  Touch(i);
}

// The tetrahedron's former item, if it may still have an operation; else a new item.
SliverIndex SliverTable::Find(const std::array<VertexIndex, 4>& v) {
  auto key = v;
  std::sort(key.begin(), key.end());
  if (const auto it = leaving_.find(key); it != leaving_.end()) {
    const SliverIndex i = it->second;
    leaving_.erase(it);
    return i;
  }
  if (free_.empty()) {
    slivers_.emplace_back();
    return static_cast<SliverIndex>(slivers_.size() - 1);
  }
  const SliverIndex i = free_.back();
  free_.pop_back();
  slivers_[i] = {};
  return i;
}

void SliverTable::Touch(SliverIndex i) {
  if (slivers_[i].is_touched) return;
  slivers_[i].is_touched = true;
  touched_.push_back(i);
}

void SliverTable::Forget() {
  for (const auto& [key, i] : leaving_) free_.push_back(i);
  leaving_.clear();
}

}  // namespace dynmesh::meshing
