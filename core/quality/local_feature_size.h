// The local feature size of input (Hudson, Def. 1.3.1): lfs(x) is the radius of the least ball
// about x that meets two disjoint features. Features are points, segments, and in 3D polygons;
// edges of polygons count as segments. It is 1-Lipschitz.
//
// A mesh is size-conforming if no vertex has a neighbour that is much nearer than the local feature
// size there.
#ifndef DYNMESH_CORE_QUALITY_LOCAL_FEATURE_SIZE_H_
#define DYNMESH_CORE_QUALITY_LOCAL_FEATURE_SIZE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/facet_interior.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/point.h"
#include "dynmesh/feature.h"

namespace dynmesh::quality {

// Immutable, thread-safe.
class LocalFeatureSize {
 public:
  // `features`: those of a mesh of `dimension`. Sizing features, and features that name absent
  // points, are left out. 2D: z is 0.
  // O(n lg n).
  LocalFeatureSize(std::span<const Feature> features, int dimension);

  // Infinite if no two features are disjoint. About O(lg n) and the features within that distance.
  double At(const geometry::Point3& x) const;

 private:
  struct Bounds {
    geometry::Point3 lo{}, hi{};
  };
  struct Facet {
    std::vector<geometry::Ring3> rings;
    geometry::FacetPlane plane;
    geometry::FacetInterior interior;
  };
  struct Item {
    Bounds box;
    geometry::Point3 p{}, q{};  // ends
    std::uint32_t facet = kNone;
    std::vector<FeatureId> points;  // of the input, sorted
  };
  // Children are nodes number left and left + 1; a leaf has items first to last - 1.
  struct Node {
    Bounds box;
    std::uint32_t left = kNone;
    std::uint32_t first = 0, last = 0;
  };
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  void AddSegment(const geometry::Point3& p, const geometry::Point3& q,
                  std::vector<FeatureId> ends);
  void Build(std::uint32_t node, std::uint32_t first, std::uint32_t last);
  double DistanceTo(const Item& item, const geometry::Point3& x) const;

  std::vector<Item> items_;
  std::vector<Facet> facets_;
  std::vector<Node> nodes_;
};

}  // namespace dynmesh::quality

#endif  // DYNMESH_CORE_QUALITY_LOCAL_FEATURE_SIZE_H_
