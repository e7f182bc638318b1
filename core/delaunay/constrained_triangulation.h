// The constrained Delaunay triangulation of a changing set of 2D points and segments. Exact, and
// unique because ties are broken by coordinates, as in DelaunayTriangulation: a function of points
// and segments alone, whatever the order of changes.
//
// A segment is an edge, whatever its circles hold. A triangle's circle holds no vertex that can be
// seen from its inside; segments block the view. Without segments this is the Delaunay
// triangulation, and costs what that costs.
//
// Segments have their ends among the vertices, no vertex in their inside, and no point in common
// but ends. Sides of the box may be segments.
//
// Thread-compatible. Insert and Remove cost O(degree) with a good hint; a segment, the edges that
// it crosses, in most cases, and the lesser degree of its ends. Memory is that of the Delaunay
// triangulation and a byte a triangle.
#ifndef DYNMESH_CORE_DELAUNAY_CONSTRAINED_TRIANGULATION_H_
#define DYNMESH_CORE_DELAUNAY_CONSTRAINED_TRIANGULATION_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/delaunay/delaunay_triangulation.h"
#include "core/geometry/point.h"

namespace dynmesh::delaunay {

// created() and deleted() are those of the last change, of a segment, too. A triangle may be in
// both. REQUIRES of InsertAll: there are no segments yet.
class ConstrainedTriangulation : public DelaunayTriangulation {
 public:
  // As DelaunayTriangulation's. REQUIRES: p is on no segment, unless that is a side of the box.
  void Insert(VertexIndex v, const geometry::Point2& p, VertexIndex near);
  // As DelaunayTriangulation's.
  SimplexIndex Locate(const geometry::Point2& p, VertexIndex near) const {
    return segment_count_ == 0 ? DelaunayTriangulation::Locate(p, near)
                               : LocateAmongSegments(p, near);
  }
  // As DelaunayTriangulation's. REQUIRES: no segment ends at v; while there are segments, v is not
  // on a side of the box.
  void Remove(VertexIndex v);

  // Adds the segment between two vertices. False, with nothing changed, if a vertex is in its
  // inside or another segment crosses it.
  bool AddSegment(VertexIndex a, VertexIndex b);
  // REQUIRES: it is there.
  void RemoveSegment(VertexIndex a, VertexIndex b);

  bool HasSegment(VertexIndex a, VertexIndex b) const;
  std::size_t segment_count() const { return segment_count_; }

  // Checks every topological and Delaunay invariant, O(size). False with `*why` set if one is
  // violated.
  bool Check(std::string* why) const;
  std::size_t bytes() const { return DelaunayTriangulation::bytes() + marks_.capacity(); }

 private:
  using Edge = std::pair<VertexIndex, VertexIndex>;
  // By triangle: bit i says that the edge opposite to corner i is a segment.
  static constexpr std::uint8_t kTouched = 8;  // recorded by the current change
  static constexpr std::uint8_t MarkOf(int corner) {
    return static_cast<std::uint8_t>(1 << corner);
  }

  bool IsSegment(Corner c) const { return (marks_[c.simplex] & MarkOf(c.index)) != 0; }
  bool IsSegment(Code c) const { return IsSegment(ToCorner(c)); }
  void SetSegment(Corner c, bool is);
  // The corner opposite to the edge from a to b on its left; kNone as simplex if it is no edge.
  Corner FindEdge(VertexIndex a, VertexIndex b) const;
  SimplexIndex LocateAmongSegments(const geometry::Point2& p, VertexIndex near) const;
  void FindVisibleCavity(const geometry::Point2& p, SimplexIndex start);
  void CopyMarksTo(std::span<const SimplexIndex> fresh);

  // The edges that the segment crosses, in order from a. False as AddSegment.
  bool FindCrossed(VertexIndex a, VertexIndex b);
  bool Crosses(VertexIndex a, VertexIndex b, const Edge& edge) const;
  void FlipCrossed(VertexIndex a, VertexIndex b);
  void FillHoleByEars(const geometry::Point2& removed);
  // Flips edges until all but segments are locally Delaunay, from those in suspects_.
  void Legalize();
  void Flip(Corner c);

  void BeginFlips();
  void Touch(SimplexIndex t);
  void EndFlips();

  std::vector<std::uint8_t> marks_;
  std::size_t segment_count_ = 0;
  // Reused from call to call.
  std::deque<Edge> crossed_;
  std::vector<Edge> fresh_edges_;
  std::vector<Code> suspects_;
};

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_CONSTRAINED_TRIANGULATION_H_
