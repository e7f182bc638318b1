// The Delaunay triangulation of points in any fixed dimension, by Bowyer's and Watson's insertion:
// slow but right. In 2D and 3D DelaunayTriangulation and DelaunayTetrahedralization do the same
// much faster; this has the part of their interface that SVR uses.
//
// Exact, and unique, because ties are broken by coordinates (ball_predicates.h): a
// function of the point set, without flat simplices. The first points are the 2^D corners of a box
// that holds all others in its closed inside. Beyond the hull there is one symbolic vertex,
// kInfinite. Thread-compatible. Insert: O(simplices that come and go), each with an O(D!)
// predicate.
#ifndef DYNMESH_TESTS_CORE_SVR_VARIANTS_BOWYER_WATSON_H_
#define DYNMESH_TESTS_CORE_SVR_VARIANTS_BOWYER_WATSON_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "tests/core/svr/variants/ball_predicates.h"
#include "core/geometry/point.h"

namespace dynmesh::delaunay {

template <int D>
class BowyerWatson {
 public:
  using Point = geometry::Point<D>;
  using VertexIndex = std::uint32_t;
  using SimplexIndex = std::uint32_t;
  static constexpr VertexIndex kInfinite = ~VertexIndex{0};
  static constexpr SimplexIndex kNone = ~SimplexIndex{0};
  using Corners = std::array<VertexIndex, D + 1>;
  // The simplex's corner `index`, and the side opposite to it.
  struct Corner {
    SimplexIndex simplex;
    int index;
  };

  // Starts over with the box between lo and hi. Its corners become vertices `corners`: bit k of i
  // is set if corner i is high in coordinate k.
  void Reset(const Point& lo, const Point& hi,
             const std::array<VertexIndex, std::size_t{1} << D>& corners) {
    *this = BowyerWatson();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      Point p;
      for (int k = 0; k < D; ++k) p[k] = (i >> k & 1) != 0 ? hi[k] : lo[k];
      SetPosition(corners[i], p);
    }
    StartFrom(corners);
    vertex_count_ = D + 1;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (std::has_single_bit(i) || i == 0) continue;  // corners of the first simplex
      InsertAt(corners[i], position(corners[i]), AnyConflict(position(corners[i])));
    }
  }

  // Makes p, distinct from all points present, vertex v. `near`: a vertex; the nearer, the faster.
  void Insert(VertexIndex v, const Point& p, VertexIndex near) {
    InsertAt(v, p, Locate(p, incident_[near]));
  }
  // `conflicting` is any simplex with Conflicts(it, p).
  void InsertAt(VertexIndex v, const Point& p, SimplexIndex conflicting) {
    SetPosition(v, p);
    ++vertex_count_;
    FindCavity(p, conflicting);
    created_.clear();
    for (const Corner& rim : rim_) created_.push_back(AddBeyond(v, rim));
    LinkCreated();
    for (const SimplexIndex s : cavity_) Free(s);
  }

  // Simplices that the last insertion made, infinite ones included.
  std::span<const SimplexIndex> created() const { return created_; }

  bool Contains(VertexIndex v) const { return v < incident_.size() && incident_[v] != kNone; }
  std::size_t vertex_count() const { return vertex_count_; }
  std::size_t simplex_limit() const { return simplices_.size(); }  // indices are below
  std::size_t simplex_count() const { return finite_; }
  const Point& position(VertexIndex v) const { return points_[v]; }
  // A finite simplex is positively oriented (OrientationOf).
  const Corners& vertices(SimplexIndex s) const { return simplices_[s].corners; }
  bool IsInfinite(SimplexIndex s) const {
    return std::ranges::find(vertices(s), kInfinite) != vertices(s).end();
  }
  // The corner across the side opposite to `c`.
  Corner Opposite(Corner c) const {
    const SimplexIndex beside = simplices_[c.simplex].beside[c.index];
    for (int i = 0; i <= D; ++i) {
      if (simplices_[beside].beside[i] == c.simplex &&
          !Contains(c.simplex, simplices_[beside].corners[i])) {
        return {beside, i};
      }
    }
    return {beside, 0};
  }
  // The caller's number for each simplex; 0 for new and removed ones.
  std::uint64_t tag(SimplexIndex s) const { return simplices_[s].tag; }
  void set_tag(SimplexIndex s, std::uint64_t tag) { simplices_[s].tag = tag; }

  // Would inserting p remove the simplex?
  bool Conflicts(SimplexIndex s, const Point& p) const {
    for (int i = 0; i <= D; ++i) {
      if (vertices(s)[i] != kInfinite) continue;
      const int side = SideOf(s, i, p);
      // In the plane of a side of the hull the simplex within decides.
      return side != 0 ? side > 0 : Conflicts(simplices_[s].beside[i], p);
    }
    std::array<const Point*, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = &position(vertices(s)[i]);
    return geometry::InBall<D>(corners, p);
  }

  // Calls f(s) for each finite simplex.
  template <class F>
  void ForEachSimplex(F f) const {
    for (SimplexIndex s = 0; s < simplices_.size(); ++s) {
      if (simplices_[s].is_used && !IsInfinite(s)) f(s);
    }
  }
  // For each simplex at v, infinite ones included. O(their number), with a search among them.
  template <class F>
  void ForEachSimplexAround(VertexIndex v, F f) const {
    std::vector<SimplexIndex> found = {incident_[v]};
    for (std::size_t next = 0; next < found.size(); ++next) {
      const SimplexIndex s = found[next];
      f(s);
      for (int i = 0; i <= D; ++i) {
        if (vertices(s)[i] == v) continue;
        const SimplexIndex beside = simplices_[s].beside[i];
        if (std::ranges::find(found, beside) == found.end()) found.push_back(beside);
      }
    }
  }

  // The circumscribed ball of a finite simplex: its centre and squared radius, in long doubles by
  // elimination; infinite if that fails.
  struct Ball {
    Point centre{};
    double r2 = std::numeric_limits<double>::infinity();
  };
  Ball BallOf(SimplexIndex s) const {
    std::array<std::array<long double, D + 1>, D> m;
    const Point& o = position(vertices(s)[0]);
    for (int i = 0; i < D; ++i) {
      const Point& p = position(vertices(s)[i + 1]);
      m[i][D] = 0;
      for (int k = 0; k < D; ++k) {
        m[i][k] = static_cast<long double>(p[k]) - o[k];
        m[i][D] += m[i][k] * m[i][k] / 2;
      }
    }
    for (int column = 0; column < D; ++column) {
      int pivot = column;
      for (int i = column + 1; i < D; ++i) {
        if (std::fabs(m[i][column]) > std::fabs(m[pivot][column])) pivot = i;
      }
      if (m[pivot][column] == 0) return {};
      std::swap(m[column], m[pivot]);
      for (int i = 0; i < D; ++i) {
        if (i == column) continue;
        const long double factor = m[i][column] / m[column][column];
        for (int k = column; k <= D; ++k) m[i][k] -= factor * m[column][k];
      }
    }
    Ball ball;
    long double r2 = 0;
    for (int k = 0; k < D; ++k) {
      const long double w = m[k][D] / m[k][k];
      r2 += w * w;
      ball.centre[k] = static_cast<double>(o[k] + w);
    }
    ball.r2 = static_cast<double>(r2);
    return ball;
  }

  // Are neighbours mutual, finite simplices positively oriented, and does no simplex conflict with
  // the vertex beyond a side? By Delaunay's lemma then all are Delaunay. O(size).
  bool Check(std::string* why) const {
    for (SimplexIndex s = 0; s < simplices_.size(); ++s) {
      if (!simplices_[s].is_used) continue;
      if (!IsInfinite(s) && OrientationAt(s) <= 0) {
        *why = "simplex " + std::to_string(s) + " is not positively oriented";
        return false;
      }
      for (int i = 0; i <= D; ++i) {
        const Corner beyond = Opposite({s, i});
        if (!simplices_[beyond.simplex].is_used ||
            simplices_[beyond.simplex].beside[beyond.index] != s) {
          *why = "simplex " + std::to_string(s) + " is not the neighbour of its neighbour";
          return false;
        }
        const VertexIndex v = simplices_[beyond.simplex].corners[beyond.index];
        if (v != kInfinite && Conflicts(s, position(v))) {
          *why =
              "simplex " + std::to_string(s) + " has vertex " + std::to_string(v) + " in its ball";
          return false;
        }
      }
    }
    return true;
  }

 private:
  struct Simplex {
    Corners corners{};
    std::array<SimplexIndex, D + 1> beside{};  // across the side opposite to each corner
    std::uint64_t tag = 0;
    bool is_used = false;
    std::uint32_t walk = 0;
  };

  void SetPosition(VertexIndex v, const Point& p) {
    if (v >= points_.size()) points_.resize(v + 1), incident_.resize(v + 1, kNone);
    points_[v] = p;
  }
  bool Contains(SimplexIndex s, VertexIndex v) const {
    return std::ranges::find(vertices(s), v) != vertices(s).end();
  }
  int OrientationAt(SimplexIndex s) const {
    std::array<const Point*, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = &position(vertices(s)[i]);
    return geometry::OrientationOf<D>(corners);
  }
  // The orientation with p in place of corner i.
  int SideOf(SimplexIndex s, int i, const Point& p) const {
    std::array<const Point*, D + 1> corners;
    for (int k = 0; k <= D; ++k) corners[k] = k == i ? &p : &position(vertices(s)[k]);
    return geometry::OrientationOf<D>(corners);
  }

  SimplexIndex New(const Corners& corners) {
    SimplexIndex s;
    if (free_.empty()) {
      s = static_cast<SimplexIndex>(simplices_.size());
      simplices_.emplace_back();
    } else {
      s = free_.back();
      free_.pop_back();
    }
    simplices_[s] = {corners, {}, 0, true, 0};
    for (const VertexIndex v : corners) {
      if (v != kInfinite) incident_[v] = s;
    }
    if (!IsInfinite(s)) ++finite_;
    return s;
  }
  void Free(SimplexIndex s) {
    if (!IsInfinite(s)) --finite_;
    simplices_[s].is_used = false;
    simplices_[s].tag = 0;
    free_.push_back(s);
  }

  // One simplex at corner 0, and beyond each of its sides an infinite one.
  void StartFrom(const std::array<VertexIndex, std::size_t{1} << D>& corners) {
    Corners first;
    first[0] = corners[0];
    for (int k = 0; k < D; ++k) first[k + 1] = corners[std::size_t{1} << k];
    created_ = {New(first)};  // the axes are positively oriented
    for (int i = 0; i <= D; ++i) {
      Corners beyond = first;
      beyond[i] = kInfinite;
      // So that with a position outside in place of kInfinite it is positive.
      std::swap(beyond[i == 0 ? 1 : 0], beyond[i <= 1 ? 2 : 1]);
      created_.push_back(New(beyond));
    }
    LinkAll(created_);
  }
  // Links those of `all` with a side in common.
  void LinkAll(const std::vector<SimplexIndex>& all) {
    absl::flat_hash_map<std::array<VertexIndex, D>, Corner> open;
    for (const SimplexIndex s : all) {
      for (int i = 0; i <= D; ++i) LinkSide({s, i}, open);
    }
  }
  void LinkSide(Corner c, absl::flat_hash_map<std::array<VertexIndex, D>, Corner>& open) {
    std::array<VertexIndex, D> side;
    for (int k = 0, at = 0; k <= D; ++k) {
      if (k != c.index) side[at++] = simplices_[c.simplex].corners[k];
    }
    std::sort(side.begin(), side.end());
    const auto [it, is_new] = open.try_emplace(side, c);
    if (is_new) return;
    simplices_[c.simplex].beside[c.index] = it->second.simplex;
    simplices_[it->second.simplex].beside[it->second.index] = c.simplex;
  }

  // A simplex that conflicts with p. O(size).
  SimplexIndex AnyConflict(const Point& p) const {
    for (SimplexIndex s = 0; s < simplices_.size(); ++s) {
      if (simplices_[s].is_used && Conflicts(s, p)) return s;
    }
    return kNone;
  }
  // Walks from `from` towards p, across a side that has p beyond it. The side is chosen in turn, so
  // that the walk does not go around for ever. (In a Delaunay triangulation none does.)
  SimplexIndex Locate(const Point& p, SimplexIndex from) const {
    SimplexIndex s = from;
    for (int i = 0; IsInfinite(s) && i <= D; ++i) {
      if (vertices(s)[i] == kInfinite) s = simplices_[s].beside[i];
    }
    for (bool moved = true; moved && !IsInfinite(s);) {
      moved = false;
      for (int i = 0; i <= D && !moved; ++i) {
        if (SideOf(s, i, p) >= 0) continue;
        s = simplices_[s].beside[i];
        moved = true;
      }
    }
    return s;
  }

  // cavity_: the simplices in conflict with p; rim_: their corners opposite to sides that stay.
  void FindCavity(const Point& p, SimplexIndex start) {
    ++walk_;
    cavity_.assign(1, start);
    rim_.clear();
    simplices_[start].walk = walk_;
    for (std::size_t next = 0; next < cavity_.size(); ++next) {
      const SimplexIndex s = cavity_[next];
      for (int i = 0; i <= D; ++i) {
        const SimplexIndex beside = simplices_[s].beside[i];
        if (simplices_[beside].walk == walk_) continue;
        if (Conflicts(beside, p)) {
          simplices_[beside].walk = walk_;
          cavity_.push_back(beside);
        } else {
          rim_.push_back({s, i});
        }
      }
    }
    // A neighbour may have joined the cavity after its side was listed.
    std::erase_if(rim_, [&](const Corner& c) {
      return simplices_[simplices_[c.simplex].beside[c.index]].walk == walk_;
    });
  }
  // The new simplex with v in place of the rim's corner, linked across that side.
  SimplexIndex AddBeyond(VertexIndex v, const Corner& rim) {
    const Corner outside = Opposite(rim);
    Corners corners = simplices_[rim.simplex].corners;
    corners[rim.index] = v;
    const SimplexIndex s = New(corners);
    simplices_[s].beside[rim.index] = outside.simplex;
    simplices_[outside.simplex].beside[outside.index] = s;
    new_corner_.resize(simplices_.size());
    new_corner_[s] = rim.index;
    return s;
  }
  // Across the sides with the new vertex.
  void LinkCreated() {
    absl::flat_hash_map<std::array<VertexIndex, D>, Corner> open;
    for (const SimplexIndex s : created_) {
      for (int i = 0; i <= D; ++i) {
        if (i != new_corner_[s]) LinkSide({s, i}, open);
      }
    }
  }

  std::vector<Point> points_;
  std::vector<SimplexIndex> incident_;  // by vertex
  std::vector<Simplex> simplices_;
  std::vector<SimplexIndex> free_;
  std::size_t vertex_count_ = 0, finite_ = 0;
  std::uint32_t walk_ = 0;
  std::vector<SimplexIndex> created_, cavity_;
  std::vector<Corner> rim_;
  std::vector<int> new_corner_;
};

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_TESTS_CORE_SVR_VARIANTS_BOWYER_WATSON_H_
