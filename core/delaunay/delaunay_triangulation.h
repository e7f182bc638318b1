// The Delaunay triangulation of a changing set of 2D points. Exact, and unique because ties are
// broken by coordinates (geometry/predicates.h). It is a function of the point set alone, whatever
// the order of insertions and removals.
//
// The first four points are the corners of a box that holds all others in its closed inside.
// Further points may lie on the box's sides. These may be removed like any other; only the corners
// stay. Beyond the hull there is one symbolic vertex, kInfinite, so that every edge has two
// triangles.
//
// This class holds topology only; vertices are the caller's indices. Thread-compatible. Insert and
// Remove cost O(degree) with a good hint. Memory is 64 bytes per triangle, 20 per vertex index.
#ifndef DYNMESH_CORE_DELAUNAY_DELAUNAY_TRIANGULATION_H_
#define DYNMESH_CORE_DELAUNAY_DELAUNAY_TRIANGULATION_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/delaunay/triangle_table.h"
#include "core/geometry/point.h"

namespace dynmesh::delaunay {

class DelaunayTriangulation : public TriangleTable {
 public:
  // Starts over with the box that has corners lo and hi. Its corners become vertices `corners` in
  // the order (lo,lo) (hi,lo) (hi,hi) (lo,hi). lo < hi in both coordinates.
  void Reset(const geometry::Point2& lo, const geometry::Point2& hi,
             const std::array<VertexIndex, 4>& corners);

  // Makes p, distinct from all points present, vertex v (an index not in use). `near` is any
  // present vertex; the nearer, the faster. See created() and deleted() for the changes.
  void Insert(VertexIndex v, const geometry::Point2& p, VertexIndex near) {
    InsertAt(v, p, Locate(p, near));
  }

  // Insert without the walk: `conflicting` is any triangle with Conflicts(it, p).
  void InsertAt(VertexIndex v, const geometry::Point2& p, SimplexIndex conflicting);

  // n vertices have exactly 2 n - 2 triangles, infinite ones included, and there are never more
  // slots than there once were triangles. Codes have 30 bits for a triangle: enough below 2^29
  // vertices.
  static constexpr bool is_full() { return false; }

  // Removes vertex v, none of the four corners. O(degree log degree) expected.
  void Remove(VertexIndex v);

  // Inserts many points in an order that is fast whatever the input (rounds of random priority,
  // Hilbert order within a round). indices.size() == points.size(). Leaves created() and deleted()
  // empty.
  void InsertAll(std::span<const VertexIndex> indices, std::span<const geometry::Point2> points);

  // Triangles that the last Insert or Remove made / deleted, infinite ones included. Created ones
  // may reuse indices of deleted ones, so deleted ones are given by their vertices. Valid until the
  // next change. Created ones of an Insert have the new vertex as corner 2, in counter-clockwise
  // order around it.
  std::span<const SimplexIndex> created() const { return created_; }
  std::span<const std::array<VertexIndex, 3>> deleted() const { return deleted_; }
  // Their tags.
  std::span<const std::uint64_t> deleted_tags() const { return deleted_tags_; }

  // A triangle that contains p (closed; infinite only if p is outside the box), searched from
  // `near`. If p is no vertex, the triangle conflicts with p.
  SimplexIndex Locate(const geometry::Point2& p, VertexIndex near) const;

  // Reserves room for that many vertices (indices below it) without further allocation.
  void Reserve(std::size_t vertices);

  // Checks every topological and Delaunay invariant, O(size). False with `*why` set if one is
  // violated.
  bool Check(std::string* why) const;
  std::size_t bytes() const;

 protected:
  // An edge a->b of the rim of a hole, with the hole on its left, and the corner that faces it from
  // outside.
  struct RimEdge {
    VertexIndex a, b;
    Code outside;
  };

  void FillCavityFrom(VertexIndex v, const geometry::Point2& p);
  // The first step of a removal.
  void OpenHole(VertexIndex v);
  SimplexIndex TakeSlot();
  // As Check, but not across edges that may be flat: those with `is_fixed(c)` for the corner c
  // opposite to them.
  bool CheckBut(absl::FunctionRef<bool(Corner)> is_fixed, std::string* why) const;

  std::vector<SimplexIndex> created_;
  std::vector<std::array<VertexIndex, 3>> deleted_;
  std::vector<std::uint64_t> deleted_tags_;
  // Reused from call to call to avoid allocation.
  std::vector<SimplexIndex> cavity_;
  std::vector<RimEdge> rim_;

 private:
  // A chain rim_[first..last] (by its vertices a) that is still to be filled, and the corner that
  // faces its closing edge last->first.
  struct Gap {
    std::size_t first, last;
    Code outside;
  };

  SimplexIndex LocateFrom(const geometry::Point2& p, SimplexIndex start) const;
  // Fills cavity_ with the triangles in conflict with p and rim_ with the edges around them.
  void FindCavity(const geometry::Point2& p, SimplexIndex start);

  // Removal, in delaunay_removal.cc.
  void CloseHullGap();
  void FillHoleByScanning();
  std::size_t FindApex(const Gap& gap) const;
  void FillHoleByTriangulating(const geometry::Point2& removed);

  // Checks, in delaunay_check.cc.
  bool CheckTriangle(SimplexIndex t, absl::FunctionRef<bool(Corner)> is_fixed,
                     std::string* why) const;
  bool CheckVertices(std::string* why) const;

  std::array<VertexIndex, 4> corners_ = {};

  // Reused from call to call to avoid allocation.
  std::vector<Code> stack_;
  std::vector<Gap> gaps_;
};

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_DELAUNAY_TRIANGULATION_H_
