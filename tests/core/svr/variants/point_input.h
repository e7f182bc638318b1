// Points as the input of SVR (svr.h), in any dimension.
#ifndef DYNMESH_TESTS_CORE_SVR_VARIANTS_POINT_INPUT_H_
#define DYNMESH_TESTS_CORE_SVR_VARIANTS_POINT_INPUT_H_

#include <cstddef>
#include <vector>

#include "core/geometry/point.h"
#include "core/svr/hilbert_order.h"
#include "core/svr/options.h"
#include "tests/core/svr/variants/kernel_4d.h"

namespace dynmesh::svr {

template <int D>
class PointInput {
 public:
  using Point = geometry::Point<D>;
  static constexpr bool kHasFeatures = false;

  // `points`: distinct, in the domain. After the border they are numbered in the order of
  // HilbertOrder.
  PointInput(const Options<D>& options, std::vector<Point> points);

  // The positions of border and input by index.
  const std::vector<Point>& positions() const { return positions_; }
  std::size_t border_count() const { return border_count_; }
  // The points in the order in which they are located.
  std::vector<VertexIndex> Waiting() const;
  // Is v a vertex in open space?
  bool IsSteiner(VertexIndex v) const { return v >= positions_.size(); }
  bool IsInput(VertexIndex v) const { return v >= border_count_ && !IsSteiner(v); }
  // A new vertex.
  VertexIndex AddSteiner(const SteinerPoint<D>& /*steiner*/) { return end_++; }
  void SetPresent(VertexIndex /*v*/) {}
  // Of the simplex's edges that count for its quality.
  double SquaredShortestEdge(const Kernel<D>& mesh, SimplexIndex s) const {
    return svr::SquaredShortestEdge<D>(mesh, s);
  }
  bool IsTooLarge(const Ball<D>& /*ball*/) const { return false; }

 private:
  std::vector<Point> positions_;
  std::size_t border_count_ = 0;
  VertexIndex end_ = 0;
};

}  // namespace dynmesh::svr

#endif  // DYNMESH_TESTS_CORE_SVR_VARIANTS_POINT_INPUT_H_
