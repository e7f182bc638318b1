// Maps the client's features to the shapes of a quadtree. Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_SHAPE_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_SHAPE_TABLE_H_

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/plc/delta.h"
#include "core/quadtree/shape.h"
#include "dynmesh/feature.h"

namespace dynmesh {

template <int D>
class ShapeTable {
 public:
  // Applies a change of input to the tree. Removals first; a feature is removed before, and added
  // after, those that it depends on.
  template <class Tree>
  void Apply(const plc::Delta<D>& delta, Tree& tree) {
    for (const plc::FacetFeature& f : delta.removed_facets) Remove(facets_, f.id, tree);
    for (const plc::SegmentFeature<D>& s : delta.removed_segments) {
      Remove(segments_, plc::KeyOf(s), tree);
    }
    for (const plc::PointFeature<D>& p : delta.removed_points) {
      const auto at = points_.find(p.id);
      tree.Remove(at->second.shape);
      free_points_.push_back(at->second.index);
      points_.erase(at);
    }
    points_.reserve(points_.size() + delta.added_points.size());
    segments_.reserve(segments_.size() + delta.added_segments.size());
    for (const plc::PointFeature<D>& p : delta.added_points) {
      const quadtree::PointIndex index = NewPoint();
      points_[p.id] = {index, tree.Add(Shape::OfPoint(p.p, index))};
    }
    for (const plc::SegmentFeature<D>& s : delta.added_segments) {
      segments_[plc::KeyOf(s)] =
          tree.Add(Shape::OfSegment(s.p, s.q, points_.at(s.p_id).index, points_.at(s.q_id).index));
    }
    if constexpr (D == 3) {
      for (const plc::FacetFeature& f : delta.added_facets) {
        std::vector<quadtree::PointIndex> corners;
        for (const auto& ring : f.rings) {
          for (const FeatureId id : ring) corners.push_back(points_.at(id).index);
        }
        facets_[f.id] = tree.Add(Shape::OfFacet(
            std::make_shared<const quadtree::FacetShape>(f.positions, std::move(corners))));
      }
    }
  }

  std::size_t bytes() const {
    const auto of = [](const auto& map) { return map.capacity() * (sizeof(*map.begin()) + 1); };
    return of(points_) + of(segments_) + of(facets_) +
           free_points_.capacity() * sizeof(quadtree::PointIndex);
  }

 private:
  using Shape = quadtree::Shape<D>;
  struct Point {
    quadtree::PointIndex index;
    quadtree::ShapeIndex shape;
  };

  template <class Map, class Key, class Tree>
  static void Remove(Map& map, const Key& key, Tree& tree) {
    const auto at = map.find(key);
    tree.Remove(at->second);
    map.erase(at);
  }
  quadtree::PointIndex NewPoint() {
    if (free_points_.empty()) return next_point_++;
    const quadtree::PointIndex index = free_points_.back();
    free_points_.pop_back();
    return index;
  }

  absl::flat_hash_map<FeatureId, Point> points_;
  absl::flat_hash_map<plc::EdgeKey, quadtree::ShapeIndex> segments_;  // edges of polygons, too
  absl::flat_hash_map<FeatureId, quadtree::ShapeIndex> facets_;
  std::vector<quadtree::PointIndex> free_points_;
  quadtree::PointIndex next_point_ = 0;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_SHAPE_TABLE_H_
