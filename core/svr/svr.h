// Sparse Voronoi Refinement (Hudson, Dynamic Mesh Refinement, chapters 2 and 3): a static mesher in
// O(n lg L/s + m), for points.
//
// It never has a bad mesh: it begins with a coarse mesh of good quality, and inserts the input into
// it little by little. Work, the most urgent first:
//   1. skinny simplices, with circumradius / shortest edge > kKept: the mesh stays as good as this;
//   2. crowded vertices, whose Voronoi cells have input points that are not in the mesh yet;
//   3. simplices of a quality between the asked and that one.
// Within a kind, the latest first: so work stays where it is, and memory in caches.
//
// A simplex is split at its circumcenter, or at an input point in the ball of k times its radius
// about it. Of a crowded vertex one point p is looked at, of those farthest from it. If the vertex
// is a Steiner point, p is inserted. If it is an input point, p may be too near to it: the largest
// of its simplices with p in the circumball is split. (The thesis splits the largest of all its
// simplices. That makes up to a sixth more vertices, where there are no points on one side of it.)
//
// The result is a function of the set of points: input is sorted first, and nothing else depends on
// its order.
#ifndef DYNMESH_CORE_SVR_SVR_H_
#define DYNMESH_CORE_SVR_SVR_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "core/svr/kernel.h"
#include "core/svr/voronoi_location.h"

namespace dynmesh::svr {

template <int D>
struct Options {
  // The domain: a square, cube, ... It should be 4 times as large as the points' extent, or larger:
  // simplices with a circumcenter outside are not split.
  geometry::Point<D> lo{}, hi{};
  int border_cells = 0;  // of the grid on each side of the domain
  double quality = 2;    // rho
  double k = 0.9;        // how far input points attract a circumcenter
};

struct Counts {
  std::uint64_t skinny = 0, crowded = 0, moderate = 0;  // items of work done
  std::uint64_t warped = 0;                             // circumcenters moved to input points
  std::uint64_t outside = 0;  // circumcenters outside the domain, or unknown
};

template <int D, class Location = VoronoiLocation<D, true>>
class Svr {
 public:
  using Point = geometry::Point<D>;

  // `points`: distinct, in the domain.
  Svr(const Options<D>& options, std::vector<Point> points);

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

  const Kernel<D>& mesh() const { return mesh_; }
  // The first vertices are those of the border's grid.
  std::size_t border_count() const { return border_count_; }
  // 2D: these, counter-clockwise.
  std::vector<VertexIndex> BorderAround() const requires(D == 2);
  // Items of work that are known.
  std::size_t waiting() const {
    return work_[kSkinny].size() + work_[kCrowded].size() + work_[kModerate].size();
  }
  // Of an input point its index in the sorted input; kNone of others.
  PointIndex InputOf(VertexIndex v) const { return input_[v]; }
  const Counts& counts() const { return counts_; }
  const LocationCounts& location_counts() const { return location_.counts(); }
  // The greatest circumradius / shortest edge, squared, of the present mesh, where the
  // circumcenter is in the domain.
  double WorstSquaredRatio() const;
  // No simplex waits that is worse than kKept times the asked quality.
  bool is_kept() const { return work_[kSkinny].empty(); }

 private:
  static constexpr double kKept = 2;  // times the asked quality
  enum Kind : std::uint8_t { kSkinny, kCrowded, kModerate, kKinds };
  struct Item {
    Kind kind = kSkinny;
    std::uint32_t of = kNone;  // simplex or vertex
    std::uint64_t serial = 0;  // of the simplex: another one may have its index
  };

  void AddBorder();
  // The most urgent item that still stands. False if there is none.
  bool Next(Item* item);
  void Do(const Item& item);
  void DoCrowded(VertexIndex v);
  // At the circumcenter of s or an input point near it. False: that is not in the domain.
  bool Split(SimplexIndex s);
  void Insert(const Point& p, PointIndex input, SimplexIndex conflicting);
  void Enter(SimplexIndex s);
  void EnterCrowded(VertexIndex v);
  bool IsInDomain(const Point& p) const;

  const Options<D> options_;
  const std::vector<Point> points_;  // sorted
  Kernel<D> mesh_;
  std::size_t border_count_ = 0;
  Location location_;
  std::vector<PointIndex> input_;  // by vertex
  std::vector<bool> is_entered_;   // by vertex: it has an item
  std::array<std::vector<Item>, kKinds> work_;
  std::uint64_t serial_ = 0;
  Counts counts_;
};

extern template class Svr<2, VoronoiLocation<2, true>>;
extern template class Svr<2, VoronoiLocation<2, false>>;
extern template class Svr<3, VoronoiLocation<3, true>>;
extern template class Svr<3, VoronoiLocation<3, false>>;
extern template class Svr<4, VoronoiLocation<4, true>>;

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_SVR_H_
