// Points, segments, polygons (3D) and sizing features as the input of SVR (svr.h).
//
// It is the complex of the dynamic mesher without its time: so what a vertex lies on, how a
// subsegment is split (meshing/shells.h where segments meet at sharp angles), which edges count,
// where a facet is cut, and how a mesh is reported are the same code.
#ifndef DYNMESH_CORE_SVR_PLC_INPUT_H_
#define DYNMESH_CORE_SVR_PLC_INPUT_H_

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/point.h"
#include "core/meshing/box_tree.h"
#include "core/meshing/cell_cut.h"
#include "core/meshing/complex.h"
#include "core/meshing/input_sink.h"
#include "core/meshing/mesh_source.h"
#include "core/meshing/shells.h"
#include "core/svr/kernel.h"
#include "core/svr/options.h"
#include "dynmesh/options.h"

namespace dynmesh::svr {

// In place of an engine: elements have no time.
template <class Program>
struct NoEngine {
  static constexpr bool kTraced = false;
  struct Context {};
};

// Thread-compatible.
template <int D>
class PlcInput final : public meshing::InputSink<D>, public meshing::MeshSource<D> {
 public:
  using Point = geometry::Point<D>;
  using Complex = meshing::Complex<D, NoEngine>;
  using Vertex = meshing::Vertex<D>;
  using Subsegment = meshing::Subsegment<D>;
  using OnChange = typename meshing::MeshSource<D>::OnChange;
  static constexpr bool kHasFeatures = true;

  explicit PlcInput(const MeshOptions& options);

  // --- Input: before Svr is made --------------------------------------------------------------

  VertexIndex AddPoint(const Point& p, meshing::FeatureSlot feature) override;
  SubsegmentIndex AddSegment(VertexIndex a, VertexIndex b, meshing::FeatureSlot feature,
                             const meshing::SegmentShape& shape = {}) override;
  typename meshing::SizingField<D>::Index AddSizing(
      const meshing::SizingRegion<D>& region) override {
    return complex_.sizing.Add(region);
  }
  FacetIndex AddFacet(std::span<const std::vector<VertexIndex>> rings,
                      meshing::FeatureSlot feature) override;

  // --- For Svr ----------------------------------------------------------------------------

  Options<D> options() const;
  std::vector<Point> positions() const;
  std::size_t border_count() const { return border_count_; }
  std::vector<VertexIndex> Waiting();
  const Point& position(VertexIndex v) const { return complex_.vertex(v).p; }
  bool IsSteiner(VertexIndex v) const { return complex_.vertex(v).dimension == D; }
  VertexIndex AddSteiner(const SteinerPoint<D>& steiner);
  void SetPresent(VertexIndex v) { complex_.elements.SetPresent(v, true); }
  // Of the edges that count: those between two segments of a wedge, on one shell, do not.
  double SquaredShortestEdge(const Kernel<D>& mesh, SimplexIndex s) const;
  // Is the ball too large for a sizing feature?
  bool IsTooLarge(const Ball<D>& ball) const { return complex_.IsTooLarge(ball.centre, ball.r2); }

  // Subsegments: those not split are present.
  bool IsPresent(SubsegmentIndex s) const { return complex_.subsegment(s).death == sac::kNoStamp; }
  VertexIndex LesserEnd(SubsegmentIndex s) const { return complex_.subsegment(s).a; }
  // Calls f(s) for the subsegments that have p in their open diametral balls.
  template <class F>
  void ForEachEncroached(const Point& p, F f) const {
    balls_.Any(p, 0, INFINITY, [&](std::uint32_t i) {
      const Subsegment& s = complex_.subsegment(balls_[i].s);
      if (geometry::InDiametralBall(position(s.a), position(s.b), p)) f(balls_[i].s);
      return false;
    });
  }
  // Calls f(s, an end, the other end) for all but those of the border.
  template <class F>
  void ForEachSubsegment(F f) const {
    for (const SubsegmentIndex whole : wholes_) ForEachPart(whole, f);
  }
  // False if its parts would be finer than limits allow. Then hit_depth_limit().
  bool CanSplit(SubsegmentIndex s);
  // Is s too short to be split for the sake of an edge of squared length e2?
  bool IsGuarded(SubsegmentIndex s, double e2) const;
  // Splits s. Returns the new vertex, which is not inserted yet.
  VertexIndex Split(SubsegmentIndex s);

  bool has_facets() const { return D == 3 && !complex_.facets.empty(); }
  // The corner, farthest from v, of what a facet that v is not on has in the Voronoi cell of v; or
  // v's counterpart on the facet.
  std::optional<SteinerPoint<D>> FindFacetPoint(const Kernel<D>& mesh, VertexIndex v);
  // The foot of the ball's centre on a facet that is nearer than kNearFacet of the radius
  // (meshing/facet_work.h), or the centre.
  SteinerPoint<D> MoveToFacet(const Ball<D>& ball) const;

  // --- Results ------------------------------------------------------------------------------

  const Complex& complex() const { return complex_; }
  const meshing::ElementStore<D>& elements() const override { return complex_.elements; }
  const meshing::FacetField& facets() const override { return complex_.facets; }
  const Vertex& vertex(VertexIndex v) const { return complex_.vertex(v); }
  const Subsegment& subsegment(SubsegmentIndex s) const { return complex_.subsegment(s); }
  std::size_t vertex_count() const { return complex_.elements.vertex_count(); }
  void TakeChanges(OnChange on_vertex, OnChange on_subsegment) override {
    complex_.elements.TakeChanges(on_vertex, on_subsegment);
  }
  // For none: there is no trace.
  void ForSomeNeighbours(VertexIndex, absl::FunctionRef<bool(VertexIndex)>) const override {}
  meshing::FeatureSlot FacetAt(VertexIndex a, VertexIndex b, VertexIndex c,
                               VertexIndex d) const override;
  bool hit_depth_limit() const { return complex_.run.hit_depth_limit(); }
  bool is_full() const { return complex_.is_full(); }
  std::optional<Point> OverflowAt() const { return std::nullopt; }

 private:
  static constexpr std::uint64_t kDead = 1;

  // A protected ball, for BoxTree.
  struct ProtectedBall {
    SubsegmentIndex s = kNone;
    Point lo = {}, hi = {};  // its centre
    double radius = 0;
    static double LeastCell() { return 0; }
    static double Key() { return 0; }
  };
  VertexIndex NewVertex(const Point& p, int dimension, meshing::FeatureSlot feature);
  void AddBall(SubsegmentIndex s);
  template <class F>
  void ForEachPart(SubsegmentIndex s, F f) const {
    const Subsegment& of = complex_.subsegment(s);
    if (IsPresent(s)) {
      f(s, of.a, of.b);
    } else {
      for (const SubsegmentIndex part : parts_[s]) ForEachPart(part, f);
    }
  }
  void FindNeighbours(const Kernel<D>& mesh, VertexIndex v);

  NoEngine<meshing::Refinement<D, NoEngine>> engine_;
  Complex complex_;
  std::size_t border_count_ = 0;
  std::vector<SubsegmentIndex> wholes_;                // the segments
  std::vector<std::array<SubsegmentIndex, 2>> parts_;  // by subsegment, of those that were split
  std::vector<std::uint32_t> balls_of_;                // by subsegment
  meshing::BoxTree<D, ProtectedBall> balls_;
  bool has_wedges_ = false;
  // Of FindFacetPoint.
  meshing::CellCut cut_;
  std::vector<meshing::CellCut::Neighbour> neighbours_;
  std::vector<VertexIndex> found_;
  StarWalk<D> star_;
};

extern template class PlcInput<2>;
extern template class PlcInput<3>;

}  // namespace dynmesh::svr

#endif  // DYNMESH_CORE_SVR_PLC_INPUT_H_
