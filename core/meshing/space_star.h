// The star of a vertex in space: its neighbours in the Delaunay tetrahedralisation of a set of
// points, built one point at a time and looked at no farther than a reach H.
//
// The *link* is a triangulated sphere: a triangle of neighbours stands for a tetrahedron at v,
// which is a *corner* of v's Voronoi cell. Six ghosts at distance 2H stand for everything
// beyond, as the four do in the plane (star.h): a corner within the cube of half-width H is a
// true one. Exact; unique for a set.
//
// One object is used for many vertices: no allocation once warm. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_SPACE_STAR_H_
#define DYNMESH_CORE_MESHING_SPACE_STAR_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::meshing {

class SpaceStar {
 public:
  using Point3 = geometry::Point3;
  using Id = std::uint32_t;
  static constexpr Id kFirstGhost = ~Id{0} - 5;
  static constexpr Id kNobody = kFirstGhost - 1;  // in free slots
  static bool IsGhost(Id id) { return id >= kFirstGhost; }

  struct Neighbour {
    Id id;
    Point3 p;
    std::array<double, 3> d;  // from v
    double d2;
    int degree;  // corners at it; 0: the slot is free
  };
  struct Corner {
    std::array<int, 3> n;       // slots of neighbours: (v, n0, n1, n2) is positive
    std::array<int, 3> across;  // the corner beyond the edge opposite to n[k]
    std::array<double, 3> w;    // its centre, from v
    double r2;                  // squared radius
    double error;               // bounds that of each of w; infinite if nothing is known
    bool verified;              // nobody else conflicts with it
  };

  void Begin(Id v, const Point3& p, double reach);
  // The k-th ghost of a vertex at p: on the axes, upwards and downwards.
  static Point3 Ghost(const Point3& p, double reach, int k) {
    Point3 ghost = p;
    ghost[k / 2] += k % 2 == 0 ? 2 * reach : -2 * reach;
    return ghost;
  }

  // A link given at once: begin, add its members, then its corners as triples of their slots
  // and the corners across, numbered in the order in which they come, close. It must be that
  // of a star of some set of points.
  void BeginLink(Id v, const Point3& p, double reach);
  int AddNeighbour(Id u, const Point3& q) { return NewNeighbour(u, q); }
  void AddCorner(const std::array<int, 3>& slots, const std::array<int, 3>& across);
  void Close();
  // Are all corners within the cube? Then no ghost would have a part in the star.
  bool IsWithinReach() const;

  // Adds u at q, if the star of the enlarged set has it. REQUIRES: not present.
  bool Insert(Id u, const Point3& q);

  // Is q inside the circumball of corner i?
  bool Conflicts(int i, const Point3& q) const {
    const std::array<double, 3> x = {q[0] - p_[0], q[1] - p_[1], q[2] - p_[2]};
    return ConflictsAt(i, x, x[0] * x[0] + x[1] * x[1] + x[2] * x[2], q);
  }

  bool Has(Id u) const {
    for (const Neighbour& n : neighbours_) {
      if (n.degree > 0 && n.id == u) return true;
    }
    return false;
  }

  int corner_count() const { return static_cast<int>(corners_.size()); }
  const Corner& corner(int i) const { return corners_[i]; }
  std::array<Id, 3> IdsOf(int i) const {
    const auto& n = corners_[i].n;
    return {neighbours_[n[0]].id, neighbours_[n[1]].id, neighbours_[n[2]].id};
  }
  // Of the corner's neighbours from v.
  double LeastDistance2(int i) const {
    const auto& n = corners_[i].n;
    return std::min({neighbours_[n[0]].d2, neighbours_[n[1]].d2, neighbours_[n[2]].d2});
  }
  template <class F>
  void ForEachNeighbour(F f) const {
    for (const Neighbour& n : neighbours_) {
      if (n.degree > 0) f(n);
    }
  }
  int slot_count() const { return static_cast<int>(neighbours_.size()); }
  static bool IsUsed(const Neighbour& n) { return n.degree > 0; }
  const Neighbour& operator[](int slot) const { return neighbours_[slot]; }
  const std::vector<Corner>& corners() const { return corners_; }
  // By slot; free ones have degree 0.
  const std::vector<Neighbour>& neighbours() const { return neighbours_; }
  void MarkVerified(int i) { corners_[i].verified = true; }
  // The corner after i around its k-th neighbour, counter-clockwise seen from outside, and
  // which of its neighbours that is.
  std::pair<int, int> NextAround(int i, int k) const {
    const int across = corners_[i].across[(k + 1) % 3];
    return {across, IndexOf(across, corners_[i].n[k])};
  }

  Id vertex() const { return v_; }
  const Point3& position() const { return p_; }
  double reach() const { return reach_; }

 private:
  bool ConflictsAt(int i, const std::array<double, 3>& x, double x2, const Point3& q) const {
    const Corner& c = corners_[i];
    const double power = x2 - 2 * (x[0] * c.w[0] + x[1] * c.w[1] + x[2] * c.w[2]);
    const double error =
        4e-15 * x2 + 4 * c.error * (std::fabs(x[0]) + std::fabs(x[1]) + std::fabs(x[2]));
    if (power > error) return false;
    if (power < -error) return true;
    return geometry::InSphere(p_, neighbours_[c.n[0]].p, neighbours_[c.n[1]].p,
                              neighbours_[c.n[2]].p, q);
  }
  int IndexOf(int i, int slot) const {
    const auto& n = corners_[i].n;
    return n[0] == slot ? 0 : n[1] == slot ? 1 : 2;
  }
  int NewNeighbour(Id u, const Point3& q);
  void ComputeCorner(int i);
  void Drop(int i);

  Id v_ = 0;
  Point3 p_ = {};
  double reach_ = 0;
  std::vector<Neighbour> neighbours_;
  std::vector<int> free_neighbours_;
  std::vector<Corner> corners_;

  struct BorderEdge {
    int a, b;     // slots: the edge as the corner inside has it
    int outside;  // the corner beyond
    int index;    // where that keeps the one inside
  };
  std::vector<int> conflicts_;
  std::vector<char> in_conflict_;  // by corner
  std::vector<BorderEdge> border_;
  std::vector<int> starts_;  // by slot: the new corner whose border edge starts there
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPACE_STAR_H_
