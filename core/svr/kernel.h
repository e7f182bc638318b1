// What SVR sees of the exact Delaunay kernels, alike in 2D and 3D. Tests add one for 4D.
#ifndef DYNMESH_CORE_SVR_KERNEL_H_
#define DYNMESH_CORE_SVR_KERNEL_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "core/base/large_vector.h"
#include "core/delaunay/number_table.h"
#include "core/delaunay/triangulation_of.h"
#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::svr {

using VertexIndex = std::uint32_t;
using SimplexIndex = std::uint32_t;
using SubsegmentIndex = std::uint32_t;
using FacetIndex = std::uint32_t;
inline constexpr std::uint32_t kNone = ~std::uint32_t{0};

// A Steiner point.
template <int D>
struct SteinerPoint {
  geometry::Point<D> p;
  FacetIndex facet = kNone;  // on which it lies
  // If it is the counterpart of a vertex (meshing/sharp_facets.h): that, and the axis.
  VertexIndex of = kNone;
  std::array<VertexIndex, 2> axis = {kNone, kNone};
};

// Of vertices and uninserted points, by index.
template <int D>
using Positions = LargeVector<geometry::Point<D>>;

template <int D>
struct KernelOf;
template <>
struct KernelOf<2> {
  using Type = delaunay::TriangulationOf<2>;
};
template <>
struct KernelOf<3> {
  using Type = delaunay::TriangulationOf<3>;
};
template <int D>
using Kernel = typename KernelOf<D>::Type;

template <int D>
struct Ball {
  geometry::Point<D> centre{};
  double r2 = std::numeric_limits<double>::infinity();  // infinite: nothing is known
};

// The circumscribed ball of a finite simplex, right to a part in 10^6 or better.
inline Ball<2> BallOf(const Kernel<2>& mesh, SimplexIndex s) {
  if (!std::isfinite(mesh.circle_error(s))) return {};
  return {mesh.circumcenter(s), mesh.squared_circumradius(s)};
}
inline Ball<3> BallOf(const Kernel<3>& mesh, SimplexIndex s) {
  if (mesh.HasSphere(s)) {
    const auto sphere = mesh.SphereOf(s);
    return {sphere.center, sphere.high};
  }
  const auto& v = mesh.vertices(s);
  const geometry::Point3& p = mesh.position(v[0]);
  const auto ball =
      geometry::CircumballOf(p, mesh.position(v[1]), mesh.position(v[2]), mesh.position(v[3]));
  return {{{p[0] + ball.w[0], p[1] + ball.w[1], p[2] + ball.w[2]}}, ball.r2};
}

template <int D>
double SquaredShortestEdge(const Kernel<D>& mesh, SimplexIndex s) {
  const auto& v = mesh.vertices(s);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < D; ++i) {
    for (int j = i + 1; j <= D; ++j) {
      least = std::min(least, geometry::SquaredDistance(mesh.position(v[i]), mesh.position(v[j])));
    }
  }
  return least;
}

// The simplices around vertices of a mesh. Keeps its memory from call to call. Thread-compatible.
template <int D>
class StarWalk {
 public:
  // Calls f(s) for each simplex at v, infinite ones included.
  template <class F>
  void ForEach(const Kernel<D>& mesh, VertexIndex v, F f) {
    if constexpr (D == 3) {
      mesh.SimplicesAround(v, &star_);
      for (const auto& [s] : star_.keys()) f(s);
    } else {
      mesh.ForEachSimplexAround(v, f);
    }
  }

 private:
  struct Nothing {};
  [[no_unique_address]] std::conditional_t<D == 3, delaunay::NumberTable<1>, Nothing> star_;
};

// Sets `found` to the neighbours of v, ascending.
template <int D>
void FindNeighbours(const Kernel<D>& mesh, VertexIndex v, StarWalk<D>* star,
                    std::vector<VertexIndex>* found) {
  found->clear();
  star->ForEach(mesh, v, [&](SimplexIndex s) {
    for (const VertexIndex u : mesh.vertices(s)) {
      if (u != Kernel<D>::kInfinite && u != v) found->push_back(u);
    }
  });
  std::sort(found->begin(), found->end());
  found->erase(std::unique(found->begin(), found->end()), found->end());
}

// Which vertex of a mesh is nearest to a position, by walks over ever nearer neighbours: fast for
// one position near another. The mesh must not change meanwhile. Thread-compatible.
template <int D>
class NearestSearch {
 public:
  using Point = geometry::Point<D>;

  // Begins at vertex `near`.
  NearestSearch(const Kernel<D>& mesh, VertexIndex near) : mesh_(mesh), near_(near) {
    FindNeighbours();
  }
  VertexIndex Find(const Point& p) {
    double least = geometry::SquaredDistance(mesh_.position(near_), p);
    while (true) {
      VertexIndex best = near_;
      for (const VertexIndex u : neighbours_) {
        const double d2 = geometry::SquaredDistance(mesh_.position(u), p);
        if (d2 < least) least = d2, best = u;
      }
      if (best == near_) return near_;
      near_ = best;
      FindNeighbours();
    }
  }

 private:
  void FindNeighbours() { svr::FindNeighbours<D>(mesh_, near_, &star_, &neighbours_); }

  const Kernel<D>& mesh_;
  VertexIndex near_;
  std::vector<VertexIndex> neighbours_;
  StarWalk<D> star_;
};
template <int D>
VertexIndex NearestVertex(const Kernel<D>& mesh, const geometry::Point<D>& p, VertexIndex near) {
  return NearestSearch<D>(mesh, near).Find(p);
}

template <int D>
bool IsEdge(const Kernel<D>& mesh, VertexIndex a, VertexIndex b) {
  bool is = false;
  mesh.ForEachSimplexAround(a, [&](SimplexIndex s) {
    is = is || std::ranges::find(mesh.vertices(s), b) != mesh.vertices(s).end();
  });
  return is;
}

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_KERNEL_H_
