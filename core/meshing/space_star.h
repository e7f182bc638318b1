// The star of a vertex v in 3D: its neighbours in the Delaunay tetrahedralisation of a set of
// points. It is built one point at a time and reaches no farther than H.
//
// The *link* is a triangulated sphere: a triangle of neighbours stands for a tetrahedron at v,
// which is a *corner* of v's Voronoi cell. Six ghosts at distance 2H stand for everything beyond,
// as the four do in 2D (planar_star.h): a corner within the cube of half-width H is a true one.
// Exact; unique for a set.
//
// One object is used for many vertices: no allocation once warm. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_SPACE_STAR_H_
#define DYNMESH_CORE_MESHING_SPACE_STAR_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
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
  static constexpr Id kNobody = kFirstGhost - 1;  // the id in free slots
  static bool IsGhost(Id id) { return id >= kFirstGhost; }

  struct Neighbour {
    Id id;
    Point3 p;
    std::array<double, 3> d;  // from v
    double d2;
    int degree;  // number of its corners; 0: the slot is free
  };
  struct Corner {
    std::array<int, 3> n;       // slots of neighbours: (v, n0, n1, n2) is positive
    std::array<int, 3> across;  // the corner beyond the edge opposite to n[k]
    std::array<double, 3> w;    // its centre, from v
    double r2;                  // squared radius
    double error;               // bounds the error of each coordinate of w; infinite if nothing is
                                // known
    bool verified;              // no other vertex conflicts with it

    // The index k of the neighbour in `slot`.
    int IndexOf(int slot) const { return n[0] == slot ? 0 : n[1] == slot ? 1 : 2; }
  };

  void Begin(Id v, const Point3& p, double reach);
  // The k-th ghost of a vertex at p: on the axes, upwards and downwards.
  static Point3 Ghost(const Point3& p, double reach, int k) {
    Point3 ghost = p;
    ghost[k / 2] += k % 2 == 0 ? 2 * reach : -2 * reach;
    return ghost;
  }

  // Takes a whole link: BeginLink; add its members; then its corners, as triples of members' slots
  // with the corners across, numbered in the order in which they are added; Close. It must be the
  // link of a star of some set of points.
  void BeginLink(Id v, const Point3& p, double reach);
  int AddNeighbour(Id u, const Point3& q) { return NewNeighbour(u, q); }
  void AddCorner(const std::array<int, 3>& slots, const std::array<int, 3>& across = {});
  // Finds the corners across, if they were not given. Needs O(members^2) space.
  void JoinCorners();
  void Close();
  // True if all corners are within the cube. Then no ghost would be in the star.
  bool IsWithinReach() const;

  // Inserts u at q if it is in the star of the enlarged set. Returns whether it is. REQUIRES: not
  // present.
  bool Insert(Id u, const Point3& q) {
    return InsertIf(u, q, [] { return true; });
  }
  // The same, if also `admits()`, which is not called for most points outside of the star.
  template <class Admits>
  bool InsertIf(Id u, const Point3& q, Admits admits) {
    return MayConflict(q) && admits() && InsertNear(u, q);
  }

  // Makes it the star that v has among its other neighbours alone. If v is on their border, returns
  // false and leaves no star.
  bool Remove(int slot);
  // Inserts those of the six ghosts that are not in the star.
  void InsertGhosts();

  // True if q is inside the circumball of corner i.
  bool Conflicts(int i, const Point3& q) const {
    const std::array<double, 3> x = {q[0] - p_[0], q[1] - p_[1], q[2] - p_[2]};
    return ConflictsAt(i, x, x[0] * x[0] + x[1] * x[1] + x[2] * x[2], q);
  }

  bool Has(Id u) const {
    unsigned found = 0;
    for (const Id id : ids_) found |= static_cast<unsigned>(id == u);
    return found != 0;
  }

  int corner_count() const { return static_cast<int>(corners_.size()); }
  const Corner& corner(int i) const { return corners_[i]; }
  std::array<Id, 3> IdsOf(int i) const {
    const auto& n = corners_[i].n;
    return {neighbours_[n[0]].id, neighbours_[n[1]].id, neighbours_[n[2]].id};
  }
  // The squared distance from v to the nearest of the corner's neighbours.
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
  // The corner after i around its k-th neighbour, counter-clockwise seen from outside, and the
  // index of that neighbour in it.
  std::pair<int, int> NextAround(int i, int k) const {
    const int across = corners_[i].across[(k + 1) % 3];
    return {across, corners_[across].IndexOf(corners_[i].n[k])};
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
  bool MayConflict(const Point3& q);
  bool InsertNear(Id u, const Point3& q);
  void FindBorder();
  void FreeNeighbours();
  bool CutEar(std::size_t j, int i, const Point3& removed);
  void DropLeftOver(std::size_t reused);
  int NewNeighbour(Id u, const Point3& q);
  void ComputeCorner(int i);
  void Drop(int i);

  Id v_ = 0;
  Point3 p_ = {};
  double reach_ = 0;
  std::vector<Neighbour> neighbours_;
  std::vector<Id> ids_;  // the neighbours' ids by slot, kNobody in free ones
  std::vector<int> free_neighbours_;
  std::vector<Corner> corners_;
  // Copies of the corners' centres and errors, in rows, to test all corners at once. There may be
  // unused room at the ends.
  std::array<std::vector<double>, 3> centres_;
  std::vector<double> errors_;
  std::vector<double> margins_;  // by corner: if > 0, certainly no conflict

  struct BorderEdge {
    int a, b;     // slots: the edge as in the corner inside
    int outside;  // the corner beyond
    int index;    // position of the inner corner in the outer one's `across`
  };
  std::vector<int> conflicts_;
  std::vector<char> in_conflict_;  // by corner
  std::vector<BorderEdge> border_;
  std::vector<int> left_, rim_;  // slots that may be free; slots around a hole
  std::vector<int> corner_at_;
  std::vector<int> starts_;  // by slot: the new corner with a border edge from there
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SPACE_STAR_H_
