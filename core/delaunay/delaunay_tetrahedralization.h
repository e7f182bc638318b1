// The Delaunay tetrahedralisation of a changing set of 3D points. Exact, and unique because ties
// are broken by coordinates (geometry/space_predicates.h). It is a function of the point set alone,
// whatever the order of insertions and removals, and has no flat tetrahedron. The 3D sibling of
// DelaunayTriangulation.
//
// The first eight points are the corners of a box that holds all others in its closed inside.
// Further points may lie on the box's faces and edges. These may be removed like any other; only
// the corners stay. Beyond the hull there is one symbolic vertex, kInfinite, so that every facet
// has two tetrahedra.
//
// This class holds topology only; vertices are the caller's indices. Movable. Thread-compatible.
// Insert costs O(tetrahedra that come and go) with a good hint. Remove costs about as much as
// inserting all neighbours of the vertex. Neither allocates once warm, except Remove if there are
// more than 64 neighbours. Memory is 72 bytes per tetrahedron (some 6.8 per vertex) and 32 per
// vertex index.
#ifndef DYNMESH_CORE_DELAUNAY_DELAUNAY_TETRAHEDRALIZATION_H_
#define DYNMESH_CORE_DELAUNAY_DELAUNAY_TETRAHEDRALIZATION_H_

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/delaunay/number_table.h"
#include "core/delaunay/tetrahedron_table.h"
#include "core/geometry/point.h"

namespace dynmesh::delaunay {

class DelaunayTetrahedralization : public TetrahedronTable {
 public:
  // Starts over with the box between lo and hi, lo < hi in all coordinates. Its corners become
  // vertices `corners`: bit k of i is set if corner i is high in coordinate k.
  void Reset(const geometry::Point3& lo, const geometry::Point3& hi,
             const std::array<VertexIndex, 8>& corners);

  // Makes p, distinct from all points present, vertex v (an index not in use). `near` is any
  // present vertex; the nearer, the faster. See created() and deleted() for the changes.
  void Insert(VertexIndex v, const geometry::Point3& p, VertexIndex near) {
    InsertAt(v, p, Locate(p, near));
  }

  // Insert without the walk: `conflicting` is any tetrahedron with Conflicts(it, p).
  void InsertAt(VertexIndex v, const geometry::Point3& p, SimplexIndex conflicting);

  // True if room for tetrahedra ran out: a code has 29 bits for one. An insertion or a removal
  // keeps the tetrahedra that it deletes until it has made others, less than two for each vertex.
  // If there might be no room for that, Insert and Remove do nothing. From then on, until Reset,
  // this is not the tetrahedralisation of the requested points.
  bool is_full() const { return is_full_; }
  void set_most_simplices(std::size_t most) { most_simplices_ = most; }  // for tests

  // Removes vertex v, none of the eight corners.
  void Remove(VertexIndex v);

  // Inserts many points in an order that is fast whatever the input (rounds of random priority,
  // Hilbert order within a round). indices.size() == points.size(). Leaves created() and deleted()
  // empty. Stops when it is full.
  void InsertAll(std::span<const VertexIndex> indices, std::span<const geometry::Point3> points);

  // Tetrahedra that the last Insert or Remove made / deleted, infinite ones included. Created ones
  // may reuse indices of deleted ones, so deleted ones are given by their vertices. Valid until the
  // next change. Created ones of an Insert have the new vertex as corner 3.
  std::span<const SimplexIndex> created() const { return created_; }
  std::span<const std::array<VertexIndex, 4>> deleted() const { return deleted_; }
  // Their tags.
  std::span<const std::uint64_t> deleted_tags() const { return deleted_tags_; }

  // A tetrahedron that contains p (closed; infinite only if p is outside the box), searched from
  // `near`. If p is no vertex, the tetrahedron conflicts with p.
  SimplexIndex Locate(const geometry::Point3& p, VertexIndex near) const {
    return LocateFrom(p, (Contains(near) ? records_[near].incident : infinite_incident_) >> 2);
  }
  SimplexIndex LocateFrom(const geometry::Point3& p, SimplexIndex start) const;

  // What inserting p would do: `simplices` would go; a tetrahedron of each of `facets` and p,
  // positive in this order, would come. `cavity` is the caller's, to be reused from call to call.
  // O(its size). REQUIRES: p is inside the hull, no vertex, and Conflicts(conflicting, p).
  struct Cavity {
    NumberTable<1> simplices;
    std::vector<std::array<VertexIndex, 3>> facets;
  };
  void CavityOf(const geometry::Point3& p, SimplexIndex conflicting, Cavity* cavity) const {
    VisitCavityOf(p, conflicting, cavity, [](Corner) { return true; });
  }
  // The same, but calls visit(facet) for each of `facets` once it is found, until visit returns
  // false. Returns whether it never did; else `cavity` is incomplete.
  template <class Visit>
  bool VisitCavityOf(const geometry::Point3& p, SimplexIndex conflicting, Cavity* cavity,
                     Visit visit) const;
  // True if the facet would be one of those, seen from the tetrahedron `facet.simplex`: that one
  // would go, the one beyond would stay.
  bool IsOnCavity(Corner facet, const geometry::Point3& p) const {
    return Conflicts(facet.simplex, p) && !Conflicts(Opposite(facet).simplex, p);
  }

  // Becomes a copy of `other`.
  void Copy(const DelaunayTetrahedralization& other);

  // Reserves room for that many vertices (indices below it). No further allocation, unless they are
  // placed so that there are more than 7 tetrahedra per vertex.
  void Reserve(std::size_t vertices);

  // Checks every topological and Delaunay invariant, O(size log size). False with `*why` set if one
  // is violated.
  bool Check(std::string* why) const;
  std::size_t bytes() const;

 private:
  // A facet of a cavity's surface, by the corners on both sides.
  struct RimFacet {
    Code inside, outside;
  };

  // Starts over with one positively oriented tetrahedron.
  void StartFrom(const std::array<VertexIndex, 4>& v, const std::array<geometry::Point3, 4>& p);
  // True if there is no room for `more` tetrahedra. Then is_full() from now on, and no change is
  // reported.
  bool Overflows(std::size_t more);
  // Fills created_ with so many unused tetrahedra.
  void Allocate(std::size_t count);
  // Reports the tetrahedra as deleted and frees them.
  void Delete(std::span<const SimplexIndex> all);

  // Fills cavity_ with the tetrahedra in conflict with p and rim_ with the facets around them.
  void FindCavity(const geometry::Point3& p, SimplexIndex start);
  void FillCavityFrom(VertexIndex v);
  void LinkByTable();
  void LinkAroundRim(std::uint32_t number);

  // Removal, in delaunay_tetrahedralization_removal.cc.
  void TriangulateLink(VertexIndex v);
  void FillHole();

  // Checks, in delaunay_tetrahedralization_check.cc.
  bool CheckTetrahedron(SimplexIndex t, std::string* why) const;
  bool CheckStars(std::string* why) const;

  std::size_t most_simplices_ = std::size_t{1} << 29;
  bool is_full_ = false;
  std::array<VertexIndex, 8> corners_ = {};

  std::vector<SimplexIndex> created_;
  std::vector<std::array<VertexIndex, 4>> deleted_;
  std::vector<std::uint64_t> deleted_tags_;

  // Reused from call to call to avoid allocation.
  std::vector<SimplexIndex> cavity_;
  std::vector<RimFacet> rim_;
  static constexpr std::uint32_t kMaxTableVertices = 32;
  std::array<Code, kMaxTableVertices * kMaxTableVertices> edges_;
  std::vector<std::array<std::uint32_t, 3>> edge_entries_;
  struct Hole;  // scratch of removals
  struct DeleteHole {
    void operator()(Hole* hole) const;
  };
  std::unique_ptr<Hole, DeleteHole> hole_;
};

// As FindCavity, but marks nothing: a tetrahedron may be tested once for each of its facets.
template <class Visit>
bool DelaunayTetrahedralization::VisitCavityOf(const geometry::Point3& p, SimplexIndex conflicting,
                                               Cavity* cavity, Visit visit) const {
  assert(Conflicts(conflicting, p));
  cavity->simplices.Clear();
  cavity->facets.clear();
  cavity->simplices.Number({conflicting});
  for (std::size_t next = 0; next < cavity->simplices.keys().size(); ++next) {
    const SimplexIndex inside = cavity->simplices.keys()[next][0];
    const Tetrahedron& from = tetrahedra_[inside];
    for (int i = 0; i < 4; ++i) {
      const SimplexIndex t = from.opposite[i] >> 2;
      if (cavity->simplices.Find({t}) != NumberTable<1>::kNone) continue;
      if (Conflicts(t, p)) {
        cavity->simplices.Number({t});
        continue;
      }
      cavity->facets.push_back(FacetAt({inside, i}));
      if (!visit(Corner{inside, i})) return false;
    }
  }
  return true;
}

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_DELAUNAY_TETRAHEDRALIZATION_H_
