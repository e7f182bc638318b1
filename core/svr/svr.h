// Sparse Voronoi Refinement (Hudson, Dynamic Mesh Refinement, chapters 2 and 3): a static mesher in
// O(n lg L/s + m).
//
// It never has a bad mesh: it begins with a coarse mesh of good quality, and inserts the input into
// it little by little. Work, the most urgent first:
//   1. encroached subsegments: a vertex was to be inserted into their diametral balls;
//   2. skinny simplices, with circumradius / shortest edge > kKept: the mesh stays as good as this;
//   3. crowded vertices, whose Voronoi cells have points of the input that are not in the mesh yet
//      (or simplices around them, as the point location says);
//   4. 3D: new vertices, whose Voronoi cells may meet a facet that they are not on;
//   5. simplices of a quality between the asked and that one, or too large for a sizing feature.
// Within a kind, the latest first: so work stays where it is, and memory in caches.
//
// A simplex is split at its circumcenter, or at an uninserted point in the ball of k times its
// radius about it. Of a crowded vertex one point p is looked at, of those farthest from it. If the
// vertex nearest to p is a Steiner point, p is inserted. If it is of the input, p may be too near
// to it: the largest of its simplices with p in the circumball is split. (The thesis splits the
// largest of all its simplices. That makes up to a sixth more vertices, where there are no points
// on one side of it.)
//
// A segment's own mesh is the list of its subsegments (plc_input.h). The diametral balls of these
// are protected: what was to be inserted into one waits until the subsegment is split. Its midpoint
// becomes an uninserted point of the mesh. In the end all balls are empty, so all subsegments are
// edges. A facet has no mesh of its own: no Voronoi cell of a vertex that is not on it may meet it
// (meshing/cell_cut.h says why that suffices).
//
// The result is a function of the set of features: input is sorted first, and nothing else depends
// on its order.
#ifndef DYNMESH_CORE_SVR_SVR_H_
#define DYNMESH_CORE_SVR_SVR_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "core/svr/kernel.h"
#include "core/svr/options.h"
#include "core/svr/plc_input.h"
#include "core/svr/voronoi_location.h"
#include "core/svr/waiting_tree.h"

namespace dynmesh::svr {

struct Counts {
  std::uint64_t encroached = 0, skinny = 0, crowded = 0, facets = 0,
                moderate = 0;  // items of work done
  std::uint64_t warped = 0;    // circumcenters moved to uninserted points
  std::uint64_t outside = 0;   // circumcenters outside the domain, or unknown
  std::uint64_t guarded = 0;   // simplices left because a subsegment is too short to be split
};

// `Input` says what is to be inserted, and what is respected: PlcInput. It names the vertices:
// first those of the border, then the points of the input, then all others. `Location` keeps the
// uninserted points: VoronoiLocation. It chooses among points, so meshes differ by it. Others of
// both, and 4D, are variants of the experiments (tests/core/svr/variants).
template <int D, class Input, class Location = VoronoiLocation<D, true>>
class Svr {
 public:
  using Point = geometry::Point<D>;

  // Both must outlive this; the mesh is to be empty.
  Svr(const Options<D>& options, Input* input, Kernel<D>* mesh);
  Svr(const Svr&) = delete;
  Svr& operator=(const Svr&) = delete;

  // Runs to the end, or until `interrupt()`, called before each item of work, returns true; then it
  // returns false.
  template <class Interrupt>
  bool Run(Interrupt interrupt) {
    for (Item item; !interrupt();) {
      if (!Next(&item)) return true;
      Do(item);
    }
    return false;
  }

  // Items of work that are known.
  std::size_t waiting() const {
    std::size_t sum = 0;
    for (const LargeVector<Item>& work : work_) sum += work.size();
    return sum;
  }
  const Counts& counts() const { return counts_; }
  const Location& location() const { return location_; }
  // The greatest circumradius / shortest edge, squared, of the present mesh, where the
  // circumcenter is in the domain.
  double WorstSquaredRatio() const;
  // No simplex waits that is worse than kKept times the asked quality.
  bool is_kept() const { return work_[kSkinny].empty(); }

 private:
  static constexpr double kKept = 2;  // times the asked quality
  enum Kind : std::uint8_t { kEncroached, kSkinny, kCrowded, kFacets, kModerate, kKinds };
  struct Item {
    Kind kind = kSkinny;
    std::uint32_t of = kNone;  // subsegment, simplex or vertex
    std::uint64_t serial = 0;  // of the simplex: another one may have its index
  };
  enum class Outcome : std::uint8_t {
    kInserted,
    kYielded,  // to subsegments, which are split first
    kLeft,     // nothing is to be done
  };

  void AddBorder();
  // The most urgent item that still stands. False if there is none.
  bool Next(Item* item);
  bool Stands(const Item& item) const;
  // Subsegments that are no edges though their balls are empty: ties. False if there is none.
  bool EnterMissing();
  void Do(const Item& item);
  void DoEncroached(SubsegmentIndex s);
  void DoCrowded(VertexIndex crowded);
  bool MayBeNear(VertexIndex v, VertexIndex p) const;
  void DoFacets(const Item& item);
  // An uninserted point in the ball of k times the radius about the circumcenter of s; kNone if
  // there is none. `ball`: of s.
  VertexIndex FindWaiting(SimplexIndex s, const Ball<D>& ball);
  // At the circumcenter of s or a point near it.
  Outcome Split(SimplexIndex s);
  // Inserts v, an uninserted point.
  Outcome InsertWaiting(VertexIndex v, SimplexIndex conflicting);
  // `e2`: the squared length of the edge that asks for it.
  Outcome InsertSteiner(const SteinerPoint<D>& steiner, SimplexIndex conflicting, double e2);
  void Insert(VertexIndex v, SimplexIndex conflicting, bool was_waiting);
  // A simplex that has p in its circumscribed ball. `v`: the vertex nearest to p, or one nearby.
  SimplexIndex ConflictNear(VertexIndex v, const Point& p);
  // What becomes of a vertex at p: kInserted if it may be inserted.
  Outcome Protect(const Point& p, double e2);
  void Enter(SimplexIndex s);
  void EnterCrowded(VertexIndex v);
  bool IsInDomain(const Point& p) const;

  const Options<D> options_;
  Input& input_;
  Kernel<D>& mesh_;
  Positions<D> positions_;  // of all vertices and uninserted points
  Location location_;
  WaitingTree<D> waiting_;
  std::vector<bool> is_entered_;  // by vertex: it has an item as a crowded one
  std::array<LargeVector<Item>, kKinds> work_;
  std::uint64_t serial_ = 0;
  StarWalk<D> star_;
  Counts counts_;
};

extern template class Svr<2, PlcInput<2>>;
extern template class Svr<3, PlcInput<3>>;

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_SVR_H_
