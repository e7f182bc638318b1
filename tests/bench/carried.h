// m_f, the part of a mesh that a feature carries, and lg(L/s) (Theorem 6.4.1): what the bounds of
// edits are stated in.
#ifndef DYNMESH_TESTS_BENCH_CARRIED_H_
#define DYNMESH_TESTS_BENCH_CARRIED_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/quadtree/shape.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"
#include "dynmesh/quadtree.h"

namespace dynmesh {

// Of a Delaunay mesh: the vertices on a feature, its corners included. s: the shortest edge.
class CarriedVertices {
 public:
  CarriedVertices(const Mesh& mesh, const MeshOptions& options) {
    for (const FeatureId owner : mesh.vertices.owners) ++of_[owner];
    const auto d = static_cast<std::size_t>(options.dimension);
    absl::flat_hash_map<VertexId, std::size_t> rows;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) rows[mesh.vertices.ids[i]] = i;
    double shortest2 = std::numeric_limits<double>::infinity();
    for (std::size_t s = 0; s < mesh.simplices.size(); s += d + 1) {
      for (std::size_t i = 0; i < d; ++i) {
        const double* p = &mesh.vertices.coordinates[d * rows.at(mesh.simplices[s + i])];
        const double* q = &mesh.vertices.coordinates[d * rows.at(mesh.simplices[s + i + 1])];
        double d2 = 0;
        for (std::size_t k = 0; k < d; ++k) d2 += (p[k] - q[k]) * (p[k] - q[k]);
        shortest2 = std::min(shortest2, d2);
      }
    }
    const Box domain = DomainBox(options);
    spread_ = std::log2((domain.hi[0] - domain.lo[0]) / std::sqrt(shortest2));
  }
  double lg_spread() const { return spread_; }
  double Count(const Feature& f) const {
    const auto it = of_.find(f.id);
    double count = it == of_.end() ? 0 : static_cast<double>(it->second);
    if (f.kind == FeatureKind::kSegment) count += 2;
    for (const auto& ring : f.rings) count += static_cast<double>(ring.size());
    return count;
  }

 private:
  absl::flat_hash_map<FeatureId, std::size_t> of_;
  double spread_ = 0;
};

// Of a quadtree: the leaves that a feature meets. s: the side of the finest leaf, L that of the
// root.
class CarriedLeaves {
 public:
  CarriedLeaves(const Mesh& mesh, const MeshOptions& options, const std::vector<Feature>& features)
      : dimension_(options.dimension) {
    const auto width = static_cast<std::size_t>(dimension_);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const auto cell = QuadtreeCellAt(options, &mesh.vertices.coordinates[i * width]);
      boxes_.push_back(cell->box);
      finest_ = std::max(finest_, cell->level);
    }
    for (const Feature& f : features) {
      if (f.kind == FeatureKind::kPoint) positions_[f.id] = f.position;
    }
  }
  double lg_spread() const { return finest_; }
  // O(leaves x corners).
  double Count(const Feature& f) const { return dimension_ == 2 ? Count<2>(f) : Count<3>(f); }

 private:
  template <int D>
  geometry::Point<D> At(FeatureId id) const {
    geometry::Point<D> p;
    for (int k = 0; k < D; ++k) p[k] = positions_.at(id)[static_cast<std::size_t>(k)];
    return p;
  }
  // A polygon of 2D is its edges.
  template <int D>
  double Count(const Feature& f) const {
    using Shape = quadtree::Shape<D>;
    std::vector<Shape> shapes;
    if (f.kind == FeatureKind::kPoint) {
      shapes.push_back(Shape::OfPoint(At<D>(f.id), 0));
    } else if (f.kind == FeatureKind::kSegment) {
      shapes.push_back(Shape::OfSegment(At<D>(f.ends[0]), At<D>(f.ends[1]), 0, 1));
    } else if constexpr (D == 3) {
      std::vector<geometry::Ring3> rings;
      for (const auto& ring : f.rings) {
        rings.emplace_back();
        for (const FeatureId id : ring) rings.back().push_back(At<3>(id));
      }
      shapes.push_back(Shape::OfFacet(
          std::make_shared<quadtree::FacetShape>(rings, std::vector<quadtree::PointIndex>())));
    } else {
      for (const auto& ring : f.rings) {
        for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
          shapes.push_back(Shape::OfSegment(At<D>(ring[j]), At<D>(ring[i]), 0, 1));
        }
      }
    }
    return static_cast<double>(std::ranges::count_if(boxes_, [&](const Box& box) {
      quadtree::Box<D> cell;
      for (int k = 0; k < D; ++k) cell.lo[k] = box.lo[k], cell.hi[k] = box.hi[k];
      return std::ranges::any_of(shapes, [&](const Shape& shape) { return shape.Meets(cell); });
    }));
  }

  const int dimension_;
  std::vector<Box> boxes_;
  int finest_ = 0;
  absl::flat_hash_map<FeatureId, std::array<double, 3>> positions_;
};

}  // namespace dynmesh

#endif  // DYNMESH_TESTS_BENCH_CARRIED_H_
