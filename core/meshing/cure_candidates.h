// The candidates of a cure: points, in a fixed order, of which the first suitable one becomes a
// vertex.
#ifndef DYNMESH_CORE_MESHING_CURE_CANDIDATES_H_
#define DYNMESH_CORE_MESHING_CURE_CANDIDATES_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/facet_plane.h"
#include "core/meshing/complex.h"
#include "core/meshing/directions.h"
#include "core/meshing/sharp_facets.h"
#include "core/meshing/sliver_table.h"

namespace dynmesh::meshing {

// Candidates have ordinals. They are tried in this order:
//   the centre;
//   points on the sliver's normal through the centre, at +-kCureHeights R;
//   shells of grid directions, at kCureShells R;
//   points on facets, which all have the last ordinal;
//   points all over the ball, which cost the most.
// Points on the normal succeed most often, as they are far from the sliver's plane: half of them
// do, of the nearest grid directions a fifth. A sliver without success in the shells mostly has two
// corners on a facet. Then one point in 100 to 1000 may succeed.
inline constexpr std::array<double, 4> kCureHeights = {0.3, 0.45, 0.6, 0.15};
inline constexpr std::array<double, 5> kCureShells = {0.15, 0.3, 0.45, 0.6, 0.75};
// On a facet: this part of the radius of the circle that the ball cuts out of its plane.
inline constexpr std::array<double, 10> kCircleParts = {0,   0.2, 0.4, 0.6, 0.8,
                                                        0.1, 0.3, 0.5, 0.7, 0.9};
inline constexpr std::uint32_t kFirstInShell = 1 + 2 * kCureHeights.size();
inline constexpr std::uint32_t kFirstInBall =
    kFirstInShell + kCureShells.size() * kGridDirections.size();
inline constexpr std::uint32_t kOnFacet = kFirstInBall + kBallPositions.size();
// Those before this one are tried strictly first (cure.h). An exempt sliver gets no other: of those
// with more, a quarter of the cured ones, the others would take half of the time.
inline constexpr std::uint32_t kFirstNotStrict = kFirstInShell + 2 * kGridDirections.size();

// The candidate of that ordinal, for ordinals below kOnFacet.
inline geometry::Point3 CandidateAt(const Sliver& sliver, std::uint32_t ordinal) {
  geometry::Point3 x = sliver.centre;
  if (ordinal == 0) return x;
  const geometry::Vector3* direction = &sliver.normal;
  double part = 1;
  if (ordinal < kFirstInShell) {
    const std::size_t i = ordinal - 1;
    part = (i % 2 == 0 ? 1 : -1) * kCureHeights[i / 2];
  } else if (ordinal < kFirstInBall) {
    const std::size_t i = ordinal - kFirstInShell;
    direction = &kGridDirections[i % kGridDirections.size()];
    part = kCureShells[i / kGridDirections.size()];
  } else {
    direction = &kBallPositions[ordinal - kFirstInBall];
  }
  const double out = part * sliver.radius;
  for (std::size_t k = 0; k < 3; ++k) x.c[k] += out * (*direction)[k];
  return x;
}

// Of facets that meet each other at small angles, only so many are tried, for one round. Between
// them there is seldom room for a point, and around an edge there may be many.
inline constexpr std::size_t kSharpCureFacets = 2;

// The facets that the ball may meet, sorted by the distance of their planes from its centre.
template <template <class> class E>
std::vector<const Facet*> FacetsNear(const Complex<3, E>& complex, const geometry::Point3& c,
                                     double radius) {
  std::vector<const Facet*> near;
  if (complex.facets.empty()) return near;
  complex.facets.ForEachNear(c, radius, [&](const Facet& facet) { near.push_back(&facet); });
  const auto key = [&](const Facet* facet) {
    std::uint64_t corners = 0;
    for (const VertexIndex v : facet->corners()) corners += geometry::HashOf(complex.vertex(v).p);
    return std::pair(std::fabs(facet->plane().Height(c)), corners);
  };
  std::sort(near.begin(), near.end(),
            [&](const Facet* a, const Facet* b) { return key(a) < key(b); });
  return near;
}

// Do some of them meet at a small angle at a common edge? O(n^2).
inline bool AnyMeetSharply(std::span<const Facet* const> facets) {
  for (std::size_t i = 0; i < facets.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (MeetSharply(*facets[i], *facets[j])) return true;
    }
  }
  return false;
}

// Calls f(ordinal, x, kNil) for the candidates of these ordinals until f returns true. Returns
// whether it did. REQUIRES: end <= kOnFacet.
template <class F>
bool AnyFreeCandidate(const Sliver& sliver, std::uint32_t first, std::uint32_t end, F f) {
  for (std::uint32_t ordinal = first; ordinal < end; ++ordinal) {
    if (f(ordinal, CandidateAt(sliver, ordinal), kNil)) return true;
  }
  return false;
}

struct CandidatesTried {
  bool found = false;   // f returned true
  bool are_all = true;  // false: not all facets were tried, since they meet at small angles
};
// Calls f(ordinal, x, facet) for the candidates from `first` on, first <= kFirstInBall, until f
// returns true. facet = kNil: x is on no facet.
template <template <class> class E, class F>
CandidatesTried ForEachCandidate(const Complex<3, E>& complex, const Sliver& sliver,
                                 std::uint32_t first, F f) {
  if (AnyFreeCandidate(sliver, first, kFirstInBall, f)) return {true};
  const geometry::Point3& c = sliver.centre;
  std::vector<const Facet*> near = FacetsNear(complex, c, sliver.radius);
  const bool is_sharp = AnyMeetSharply(near);
  if (is_sharp && near.size() > kSharpCureFacets) {
    near.erase(near.begin() + kSharpCureFacets, near.end());
  }
  for (const Facet* facet : near) {
    const geometry::FacetPlane& plane = facet->plane();
    const double h = plane.Height(c), wide2 = sliver.radius * sliver.radius - h * h;
    if (!(wide2 > 0)) continue;
    const auto [x, y] = geometry::AxesOf(plane);
    for (const double part : kCircleParts) {
      const double out = part * std::sqrt(wide2);
      for (int k = 0; k < (part == 0 ? 1 : kDirections); ++k) {
        geometry::Point3 p = c;
        for (int i = 0; i < 3; ++i) {
          const auto j = static_cast<std::size_t>(i);
          p[i] += out * (CosineOf(k) * x[j] + SineOf(k) * y[j]);
        }
        p = plane.Foot(p);
        if (facet->IsInside(p) && f(kOnFacet, p, facet->feature())) return {true};
      }
    }
  }
  return {AnyFreeCandidate(sliver, kFirstInBall, kOnFacet, f), !is_sharp};
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CURE_CANDIDATES_H_
