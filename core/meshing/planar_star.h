// The star of a vertex v in 2D: its neighbours in the Delaunay triangulation of a set of points,
// counter-clockwise. It is built one point at a time and reaches no farther than H.
//
// Four *ghosts* at distance 2H stand for everything beyond: the star is that of v in the
// triangulation of the set and the ghosts. So a corner of v's Voronoi cell within the square of
// half-width H is a true one, and nothing outside matters (Lemma 4.3.3: at its time, that is O(1)
// vertices). Exact; unique for a set.
//
// One object is used for many vertices: no allocation once warm. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_PLANAR_STAR_H_
#define DYNMESH_CORE_MESHING_PLANAR_STAR_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/predicates.h"

namespace dynmesh::meshing {

class PlanarStar {
 public:
  using Point2 = geometry::Point2;
  using Id = std::uint32_t;
  static constexpr Id kFirstGhost = ~Id{0} - 3;
  static bool IsGhost(Id id) { return id >= kFirstGhost; }

  struct Neighbour {
    Id id;
    Point2 p;
    std::array<double, 2> d;  // from v
    double d2;
    // The corner between this neighbour and the next: a vertex of v's Voronoi cell.
    std::array<double, 2> w;  // its centre, from v
    double r2;                // squared radius
    double error;             // bounds the error of each coordinate of w; infinite if nothing is
                              // known
    bool verified;            // no other vertex conflicts with it
  };

  void Begin(Id v, const Point2& p, double reach) {
    v_ = v;
    p_ = p;
    reach_ = reach;
    is_closed_ = true;
    ring_.clear();
    for (int k = 0; k < 4; ++k) Push(kFirstGhost + k, Ghost(p, reach, k));
    for (int i = 0; i < 4; ++i) ComputeCorner(i);
  }
  // The k-th ghost of a vertex at p: east, north, west, south.
  static Point2 Ghost(const Point2& p, double reach, int k) {
    const double d = k < 2 ? 2 * reach : -2 * reach;
    return k % 2 == 0 ? Point2{{p[0] + d, p[1]}} : Point2{{p[0], p[1] + d}};
  }
  // Takes a whole ring: BeginRing, append its members counter-clockwise, Close. They must be the
  // star of some set of points (and maybe ghosts). Before Close corners are unknown, but members
  // may be inserted: then every test is exact.
  void BeginRing(Id v, const Point2& p, double reach) {
    v_ = v;
    p_ = p;
    reach_ = reach;
    is_closed_ = false;
    ring_.clear();
  }
  void Append(Id u, const Point2& q) { Push(u, q); }
  void AppendGhost(Id ghost) {
    Push(ghost, Ghost(p_, reach_, static_cast<int>(ghost - kFirstGhost)));
  }
  // False if two consecutive neighbours are half a turn or more apart: then it is no star yet.
  bool Close() {
    is_closed_ = true;
    bool proper = size() >= 3;
    for (int i = 0; i < size(); ++i) {
      ComputeCorner(i);
      if (!(ring_[i].r2 < INFINITY)) proper = false;
    }
    return proper;
  }
  // Inserts those of the four ghosts that are not in the ring.
  void InsertGhosts() {
    for (Id ghost = kFirstGhost; ghost != 0; ++ghost) {  // the last ghost is the largest Id
      if (!Has(ghost)) Insert(ghost, Ghost(p_, reach_, static_cast<int>(ghost - kFirstGhost)));
    }
  }
  // True if all corners are within the square. Then no ghost would be in the star.
  bool IsWithinReach() const {
    for (const Neighbour& n : ring_) {
      const double e = n.error + 1e-9 * reach_;
      if (!(std::fabs(n.w[0]) + e < reach_ && std::fabs(n.w[1]) + e < reach_)) return false;
    }
    return true;
  }

  // Inserts u at q if it is in the star of the enlarged set. Returns whether it is. REQUIRES: not
  // present.
  bool Insert(Id u, const Point2& q);
  // The same, if also `admits()`.
  template <class Admits>
  bool InsertIf(Id u, const Point2& q, Admits admits) {
    return admits() && Insert(u, q);
  }

  // The sector between consecutive directions that holds (x, y); -1 if rounding could decide.
  // direction(i) = (dx, dy), for i < count, counter-clockwise; no sector is of pi or more.
  //
  // A new point first cuts off the corner of a Voronoi cell that is extreme in its direction. That
  // is the corner with the point between its two neighbours. So if the corner of its sector does
  // not conflict with the point, none does.
  template <class Direction>
  static int SectorOf(int count, Direction direction, double x, double y) {
    // One bit for each direction, the first one highest: on which side of it the point lies. The
    // bits are as good as random, so no branches. A block ends with the direction that begins the
    // next block; the last one ends with the first direction.
    constexpr int kBlock = 63;
    for (int from = 0; from < count; from += kBlock) {
      const int sectors = std::min(kBlock, count - from);
      std::uint64_t to_left = 0, to_right = 0;
      const auto add = [&](int i) {
        const auto [dx, dy] = direction(i);
        const double left = dx * y, right = dy * x;
        const double cross = left - right;
        const double bound = 1e-15 * (std::fabs(left) + std::fabs(right));
        to_left = 2 * to_left + static_cast<std::uint64_t>(cross > bound);
        to_right = 2 * to_right + static_cast<std::uint64_t>(cross < -bound);
      };
      for (int i = from; i < from + sectors; ++i) add(i);
      add(from + sectors == count ? 0 : from + sectors);
      // Bits by a sector's first direction: the point is between its two directions; it is unclear.
      const std::uint64_t found = to_left & to_right << 1;
      const std::uint64_t unsure = ~(to_left | to_right) & ((std::uint64_t{2} << sectors) - 2);
      if (unsure > found)
        return -1;  // an unclear sector comes before the one found, or none is
                    // found
      if (found != 0) return from + sectors - std::bit_width(found) + 1;
    }
    return -1;
  }

  // True if q is inside the circumdisc of corner i.
  bool Conflicts(int i, const Point2& q) const {
    const Neighbour& n = ring_[i];
    const double x = q[0] - p_[0], y = q[1] - p_[1];
    const double q2 = x * x + y * y;
    const double power = q2 - 2 * (x * n.w[0] + y * n.w[1]);
    const double error = 4e-15 * q2 + 4 * n.error * (std::fabs(x) + std::fabs(y));
    if (power > error) return false;
    if (power < -error) return true;
    return geometry::InCircle(p_, n.p, ring_[Next(i)].p, q);
  }

  bool Has(Id u) const {
    for (const Neighbour& n : ring_) {
      if (n.id == u) return true;
    }
    return false;
  }

  // The names of SpaceStar, for code that serves both. Corner i is between neighbour i and the
  // next.
  int corner_count() const { return size(); }
  const Neighbour& corner(int i) const { return ring_[i]; }
  std::array<Id, 2> IdsOf(int i) const { return {ring_[i].id, ring_[Next(i)].id}; }
  // The squared distance from v to the nearer of the corner's neighbours.
  double LeastDistance2(int i) const { return std::min(ring_[i].d2, ring_[Next(i)].d2); }
  template <class F>
  void ForEachNeighbour(F f) const {
    for (const Neighbour& n : ring_) f(n);
  }

  int slot_count() const { return size(); }
  static constexpr bool IsUsed(const Neighbour&) { return true; }

  int size() const { return static_cast<int>(ring_.size()); }
  int Next(int i) const { return i + 1 == size() ? 0 : i + 1; }
  int Prev(int i) const { return i == 0 ? size() - 1 : i - 1; }
  const Neighbour& operator[](int i) const { return ring_[i]; }
  void MarkVerified(int i) { ring_[i].verified = true; }

  Id vertex() const { return v_; }
  const Point2& position() const { return p_; }
  double reach() const { return reach_; }

 private:
  void Push(Id u, const Point2& q) {
    const double dx = q[0] - p_[0], dy = q[1] - p_[1];
    ring_.push_back({u, q, {dx, dy}, dx * dx + dy * dy, {0, 0}, INFINITY, INFINITY, false});
  }
  void ComputeCorner(int i);
  bool IsClearOfCorners(const Point2& q, int* at) const;
  int FindConflict(const Point2& q) const;

  Id v_ = 0;
  Point2 p_ = {};
  double reach_ = 0;
  bool is_closed_ = false;  // true if corners are known
  std::vector<Neighbour> ring_, kept_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_PLANAR_STAR_H_
