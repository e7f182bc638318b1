// Random insertions into a triangulation and removals, in 2D and 3D.
#ifndef DYNMESH_TESTS_CORE_DELAUNAY_RANDOM_EDITS_H_
#define DYNMESH_TESTS_CORE_DELAUNAY_RANDOM_EDITS_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::delaunay::testing {

// A triangulation, the list of its points, and its simplices according to created() and deleted().
template <class Triangulation, int D>
class RandomEdits {
 public:
  using Point = geometry::Point<D>;
  using Vertex = typename Triangulation::VertexIndex;
  using Simplex = typename Triangulation::SimplexIndex;

  // `empty`: of the corners alone, the first vertices.
  RandomEdits(std::uint64_t seed, Triangulation empty, const std::vector<Point>& corners)
      : random_(seed), dt_(std::move(empty)), corners_(corners) {
    for (Simplex t = 0; t < dt_.simplex_limit(); ++t) {
      if (!IsUnused(t)) told_.insert(Canonical(dt_.vertices(t)));
    }
    for (const Point& p : corners_) present_[p] = static_cast<Vertex>(present_.size());
    next_ = static_cast<Vertex>(present_.size());
  }

  void Insert(const Point& p) {
    if (present_.contains(p)) return;
    // Old indices come again, as those of a real caller do.
    Vertex v = next_;
    if (unused_.empty() || random_() % 2 == 0) {
      ++next_;
    } else {
      v = unused_.back();
      unused_.pop_back();
    }
    const auto near = std::next(present_.begin(), static_cast<long>(random_() % present_.size()));
    dt_.Insert(v, p, near->second);
    present_[p] = v;
    Hear();
    if constexpr (D == 3) {
      for (const Simplex t : dt_.created()) ASSERT_EQ(dt_.vertices(t)[3], v);
    }
    ASSERT_TRUE(dt_.Contains(v));
    ASSERT_EQ(dt_.position(v), p);
  }

  void RemoveAny() {
    if (present_.size() == corners_.size()) return;
    auto victim = std::next(present_.begin(), static_cast<long>(random_() % present_.size()));
    while (victim->second < corners_.size()) {
      if (++victim == present_.end()) victim = present_.begin();
    }
    const Vertex v = victim->second;
    dt_.Remove(v);
    present_.erase(victim);
    unused_.push_back(v);
    Hear();
    ASSERT_FALSE(dt_.Contains(v));
  }

  void Step(const Point& p, double remove_probability) {
    if (std::uniform_real_distribution<double>(0, 1)(random_) < remove_probability) {
      RemoveAny();
    } else {
      Insert(p);
    }
  }

  void ExpectSound() const {
    std::string why;
    ASSERT_TRUE(dt_.Check(&why)) << why;
    ASSERT_EQ(dt_.vertex_count(), present_.size());
    std::set<Indices> actual;
    std::size_t finite = 0;
    for (Simplex t = 0; t < dt_.simplex_limit(); ++t) {
      if (!IsUnused(t)) actual.insert(Canonical(dt_.vertices(t)));
      finite += !dt_.IsInfinite(t);
    }
    ASSERT_EQ(finite, dt_.simplex_count());
    ASSERT_EQ(actual, told_);
  }

  // Inserts its points into `fresh`, of the corners alone, in another order.
  Triangulation FromScratch(Triangulation fresh) {
    std::vector<Point> all = points();
    std::shuffle(all.begin(), all.end(), random_);
    auto v = static_cast<Vertex>(corners_.size());
    for (const Point& p : all) {
      if (std::find(corners_.begin(), corners_.end(), p) == corners_.end()) fresh.Insert(v++, p, 0);
    }
    return fresh;
  }

  const Triangulation& dt() const { return dt_; }
  std::vector<Point> points() const {
    std::vector<Point> result;
    for (const auto& [p, v] : present_) result.push_back(p);
    return result;
  }

 private:
  // Of a simplex, infinite ones included. 2D: the least first; 3D: ascending.
  using Indices = std::array<Vertex, D + 1>;
  static Indices Canonical(Indices v) {
    if constexpr (D == 2) {
      std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    } else {
      std::sort(v.begin(), v.end());
    }
    return v;
  }
  bool IsUnused(Simplex t) const {
    if constexpr (D == 2) return dt_.vertices(t)[0] == dt_.vertices(t)[1];
    if constexpr (D == 3) return dt_.IsUnused(t);
  }
  // Applies the reports to told_.
  void Hear() {
    if constexpr (D == 3) {
      ASSERT_EQ(dt_.deleted().size(), dt_.deleted_tags().size());
    }
    for (const Indices& v : dt_.deleted()) ASSERT_EQ(told_.erase(Canonical(v)), 1u);
    for (const Simplex t : dt_.created()) {
      ASSERT_EQ(dt_.tag(t), 0u);
      ASSERT_TRUE(told_.insert(Canonical(dt_.vertices(t))).second);
    }
  }

  std::mt19937_64 random_;
  Triangulation dt_;
  const std::vector<Point> corners_;
  std::map<Point, Vertex> present_;
  Vertex next_ = 0;
  std::vector<Vertex> unused_;
  std::set<Indices> told_;
};

}  // namespace dynmesh::delaunay::testing

#endif  // DYNMESH_TESTS_CORE_DELAUNAY_RANDOM_EDITS_H_
