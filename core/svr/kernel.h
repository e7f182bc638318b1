// What SVR sees of the exact Delaunay kernels, alike in 2D, 3D and 4D.
#ifndef DYNMESH_CORE_SVR_KERNEL_H_
#define DYNMESH_CORE_SVR_KERNEL_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/delaunay/bowyer_watson.h"
#include "core/delaunay/triangulation_of.h"
#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::svr {

using VertexIndex = std::uint32_t;
using SimplexIndex = std::uint32_t;
using SubsegmentIndex = std::uint32_t;
using FacetIndex = std::uint32_t;
inline constexpr std::uint32_t kNone = ~std::uint32_t{0};

template <int D>
struct KernelOf {
  using Type = delaunay::BowyerWatson<D>;
};
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
Ball<D> BallOf(const delaunay::BowyerWatson<D>& mesh, SimplexIndex s) {
  const auto ball = mesh.BallOf(s);
  return {ball.centre, ball.r2};
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

// The vertex nearest to p, by a walk from `near` over ever nearer neighbours.
template <int D>
VertexIndex NearestVertex(const Kernel<D>& mesh, const geometry::Point<D>& p, VertexIndex near) {
  double least = geometry::SquaredDistance(mesh.position(near), p);
  for (VertexIndex from = kNone; from != near;) {
    from = near;
    mesh.ForEachSimplexAround(from, [&](SimplexIndex s) {
      for (const VertexIndex u : mesh.vertices(s)) {
        if (u == Kernel<D>::kInfinite) continue;
        const double d2 = geometry::SquaredDistance(mesh.position(u), p);
        if (d2 < least) least = d2, near = u;
      }
    });
  }
  return near;
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
