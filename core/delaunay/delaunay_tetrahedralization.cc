// Construction, point location and insertion; removal and checks have files of their own.
//
// Why insertion is right whatever the degeneracy.
// 1. InSphere decides as if each position x had the height |x|^2 plus a fixed infinitesimal of its
//    own. So the finite tetrahedra are the regular triangulation T(S) of the set S with generic
//    heights. It is unique and without flat tetrahedra. All of S are vertices since |x|^2 is
//    strictly convex. In any plane that supports the hull, it is the regular triangulation of the
//    points in that plane with the same heights.
// 2. kInfinite closes T(S) to a triangulated 3-sphere. Inserting p must remove exactly what T(S)
//    has and T(S + p) has not.
// 3. A finite tetrahedron goes iff InSphere holds of it and p.
// 4. The infinite tetrahedron on hull facet f goes iff f is no facet of the new hull. If p is
//    strictly beyond f, it goes; if p is strictly on the inner side, it stays. If p is in the plane
//    of f, this plane supports the new hull as well, and f stays iff it stays in the planar regular
//    triangulation there.
// 5. This planar decision is InSphere of f, d and p for any d off the plane. The in-sphere
//    determinant is the in-circle determinant of f and p in the plane times the distance of d. In
//    its ties the coefficient of d is the volume of f and p, which is zero; the others are not all
//    zero. So the result does not depend on d: it is that of the finite tetrahedron on the other
//    side of f.
// 6. Both spheres have the rest in common. So what goes is the inside of the star of p in the new
//    one: a ball without inner vertices, connected through its facets, with the link of p as its
//    surface. Joining p to this surface gives exactly T(S + p), where nothing is flat.
// 7. p may be outside the hull. So a box can start from any four of its corners.
#include "core/delaunay/delaunay_tetrahedralization.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "core/delaunay/delaunay_insert_order.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::delaunay {

using geometry::Point3;

void DelaunayTetrahedralization::Reset(const Point3& lo, const Point3& hi,
                                       const std::array<VertexIndex, 8>& corners) {
  assert(lo[0] < hi[0] && lo[1] < hi[1] && lo[2] < hi[2]);
  const auto point_of = [&](unsigned i) {
    return Point3{{(i & 1 ? hi : lo)[0], (i & 2 ? hi : lo)[1], (i & 4 ? hi : lo)[2]}};
  };
  StartFrom({corners[0], corners[1], corners[2], corners[4]},
            {point_of(0), point_of(1), point_of(2), point_of(4)});
  for (const unsigned i : {3, 5, 6, 7}) Insert(corners[i], point_of(i), corners[0]);
  corners_ = corners;
  created_.clear();
  deleted_.clear();
  deleted_tags_.clear();
}

void DelaunayTetrahedralization::StartFrom(const std::array<VertexIndex, 4>& v,
                                           const std::array<Point3, 4>& p) {
  assert(geometry::Orientation(p[0], p[1], p[2], p[3]) > 0);
  tetrahedra_.clear();
  tags_.clear();
  records_.clear();
  free_.clear();
  vertex_count_ = 0;
  infinite_count_ = 0;
  is_full_ = false;
  for (std::size_t i = 0; i < 4; ++i) AddVertex(v[i], p[i]);
  Allocate(5);
  Make(0, v);
  // Across facet i is tetrahedron i + 1. It has the same corners with kInfinite in place of corner
  // i, and two of them exchanged to reverse it.
  for (int i = 0; i < 4; ++i) {
    std::array<VertexIndex, 4> outside = v;
    const int j = i ^ 1;
    outside[j] = kInfinite;
    outside[i] = v[j];
    Make(static_cast<SimplexIndex>(i + 1), outside);
  }
  for (int i = 0; i < 4; ++i) {
    const auto t = static_cast<SimplexIndex>(i + 1);
    Link(ToCode(0, i), ToCode(t, i ^ 1));
    // Two infinite ones share the facet of infinity and the edge of v without i and k.
    for (int k = 0; k < i; ++k) {
      const auto other = static_cast<SimplexIndex>(k + 1);
      Link(ToCode(t, tetrahedra_[t].CornerOf(v[k])),
           ToCode(other, tetrahedra_[other].CornerOf(v[i])));
    }
  }
}

void DelaunayTetrahedralization::Reserve(std::size_t vertices) {
  records_.reserve(vertices);
  tetrahedra_.reserve(7 * vertices);
  tags_.reserve(7 * vertices);
}

bool DelaunayTetrahedralization::Overflows(std::size_t more) {
  if (tetrahedra_.size() - free_.size() + more <= most_simplices_) return false;
  is_full_ = true;
  created_.clear();
  deleted_.clear();
  deleted_tags_.clear();
  return true;
}

void DelaunayTetrahedralization::Allocate(std::size_t count) {
  created_.resize(count);
  const std::size_t reused = std::min(count, free_.size());
  std::copy(free_.end() - static_cast<std::ptrdiff_t>(reused), free_.end(), created_.begin());
  free_.resize(free_.size() - reused);
  if (reused == count) return;
  std::iota(created_.begin() + static_cast<std::ptrdiff_t>(reused), created_.end(),
            simplex_limit());
  tetrahedra_.resize(tetrahedra_.size() + count - reused);
  tags_.resize(tetrahedra_.size());
}

void DelaunayTetrahedralization::Delete(std::span<const SimplexIndex> all) {
  deleted_.resize(all.size());
  deleted_tags_.resize(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    Tetrahedron& t = tetrahedra_[all[i]];
    deleted_[i] = t.v;
    deleted_tags_[i] = tags_[all[i]];
    infinite_count_ -= t.HasInfinite();
    t.v.fill(kInfinite);
  }
  free_.insert(free_.end(), all.begin(), all.end());
}

DelaunayTetrahedralization::SimplexIndex DelaunayTetrahedralization::LocateFrom(
    const Point3& p, SimplexIndex start) const {
  SimplexIndex at = start;
  int entry = -1;
  if (const Tetrahedron& t = tetrahedra_[at]; t.HasInfinite()) {
    const Corner across = ToCorner(t.opposite[t.InfiniteCorner()]);
    at = across.simplex;
  }
  while (true) {
    const Tetrahedron& t = tetrahedra_[at];
    int exit = -1;
    for (int i = 0; i < 4 && exit < 0; ++i) {
      if (i == entry) continue;
      const auto& [a, b, c] = kFacet[i];
      if (geometry::Orientation(records_[t.v[a]].point, records_[t.v[b]].point,
                                records_[t.v[c]].point, p) < 0) {
        exit = i;
      }
    }
    if (exit < 0) return at;
    const Corner across = ToCorner(t.opposite[exit]);
    at = across.simplex;
    entry = across.index;
    if (tetrahedra_[at].HasInfinite()) return at;
  }
}

void DelaunayTetrahedralization::InsertAt(VertexIndex v, const Point3& p,
                                          SimplexIndex conflicting) {
  assert(!Contains(v) && v < kInfinite / 2);
  assert(Conflicts(conflicting, p));
  // The rim is a sphere of triangles on some of the vertices, kInfinite among them.
  if (Overflows(2 * vertex_count_)) return;
  AddVertex(v, p);
  FindCavity(p, conflicting);
  FillCavityFrom(v);
}

// Breadth first; the cavity is its own queue. Afterwards the outer neighbours of its tetrahedra are
// replaced by numbers of rim facets.
void DelaunayTetrahedralization::FindCavity(const Point3& p, SimplexIndex start) {
  cavity_.clear();
  rim_.clear();
  cavity_.push_back(start);
  Tetrahedron* const tetrahedra = tetrahedra_.data();
  tetrahedra[start].Mark();
  for (std::size_t next = 0; next < cavity_.size(); ++next) {
    const SimplexIndex from = cavity_[next];
    for (int i = 0; i < 4; ++i) {
      const Code code = tetrahedra[from].opposite[i];
      Tetrahedron& t = tetrahedra[code >> 2];
      const double distance = t.SquaredDistance(p);
      if (!(distance > t.high)) {  // or not a number
        if (t.IsMarked()) continue;
        if (distance < t.low || ConflictsExactly(t, p)) {
          t.Mark();
          cavity_.push_back(code >> 2);
          for (const Code c : t.opposite) __builtin_prefetch(&tetrahedra[c >> 2]);
          continue;
        }
      }
      tetrahedra[from].opposite[i] = kRim | static_cast<Code>(rim_.size());
      rim_.push_back({ToCode(from, i), code});
    }
  }
}

void DelaunayTetrahedralization::Copy(const DelaunayTetrahedralization& other) {
  tetrahedra_ = other.tetrahedra_;
  tags_ = other.tags_;
  records_ = other.records_;
  free_ = other.free_;
  infinite_incident_ = other.infinite_incident_;
  vertex_count_ = other.vertex_count_;
  infinite_count_ = other.infinite_count_;
  most_simplices_ = other.most_simplices_;
  is_full_ = other.is_full_;
  corners_ = other.corners_;
  created_.clear();
  deleted_.clear();
  deleted_tags_.clear();
}

// Makes one tetrahedron per facet of the rim. Corner 3 is v; the others are the facet's.
void DelaunayTetrahedralization::FillCavityFrom(VertexIndex v) {
  const std::size_t count = rim_.size();
  Allocate(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto [inside, outside] = rim_[i];
    const auto& corners = tetrahedra_[inside >> 2].v;
    const auto& [a, b, c] = kFacet[inside & 3];
    Make(created_[i], {corners[a], corners[b], corners[c], v});
    Link(ToCode(created_[i], 3), outside);
  }
  // The rim is a sphere of triangles.
  if (count / 2 + 2 <= kMaxTableVertices) {
    LinkByTable();
  } else {
    for (const SimplexIndex t : created_) {
      for (std::size_t i = 0; i < 3; ++i) tetrahedra_[t].opposite[i] = kNone;
    }
    for (std::uint32_t i = 0; i < count; ++i) LinkAroundRim(i);
  }
  Delete(cavity_);
}

// Links the new tetrahedra with each other. Their facets on v are in a table by the directed edge
// that they have on the rim. Each edge is there in both directions, so every entry read has just
// been written.
void DelaunayTetrahedralization::LinkByTable() {
  const std::size_t count = created_.size();
  edge_entries_.resize(count);
  Tetrahedron* const tetrahedra = tetrahedra_.data();
  VertexRecord* const records = records_.data();
  const SimplexIndex* const created = created_.data();
  std::array<std::uint32_t, 3>* const entries = edge_entries_.data();
  Code* const edges = edges_.data();
  std::array<VertexIndex, kMaxTableVertices> numbered;
  std::uint32_t vertices = 0, infinite_number = kNone;
  const auto number = [&](VertexIndex u) {
    std::uint32_t& n = u == kInfinite ? infinite_number : records[u].number;
    if (n == kNone) {
      numbered[vertices] = u;
      n = vertices++;
    }
    return n;
  };
  for (std::size_t i = 0; i < count; ++i) {
    const SimplexIndex t = created[i];
    const std::array<VertexIndex, 4>& v = tetrahedra[t].v;
    const std::uint32_t a = number(v[0]), b = number(v[1]), c = number(v[2]);
    edges[b * kMaxTableVertices + c] = ToCode(t, 0);
    edges[c * kMaxTableVertices + a] = ToCode(t, 1);
    edges[a * kMaxTableVertices + b] = ToCode(t, 2);
    entries[i] = {c * kMaxTableVertices + b, a * kMaxTableVertices + c, b * kMaxTableVertices + a};
  }
  for (std::size_t i = 0; i < count; ++i) {
    Code* const opposite = tetrahedra[created[i]].opposite.data();
    for (std::size_t k = 0; k < 3; ++k) opposite[k] = edges[entries[i][k]];
  }
  for (std::uint32_t i = 0; i < vertices; ++i) {
    if (numbered[i] != kInfinite) records[numbered[i]].number = kNone;
  }
}

// The same for one tetrahedron, on a rim of any size; used for insertion it would cost a third more
// time. Turns inside the cavity about each edge of the facet, until the next facet of the rim. All
// turns together are at most six per tetrahedron of the cavity.
void DelaunayTetrahedralization::LinkAroundRim(std::uint32_t number) {
  const SimplexIndex made = created_[number];
  const Corner start = ToCorner(rim_[number].inside);
  for (int i = 0; i < 3; ++i) {
    if (tetrahedra_[made].opposite[i] != kNone) continue;
    // `third` is the corner of the facet to be crossed that is not on the edge.
    const Tetrahedron* t = &tetrahedra_[start.simplex];
    VertexIndex third = t->v[start.index];
    Code code = t->opposite[kFacet[start.index][i]];
    while ((code & kRim) == 0) {
      t = &tetrahedra_[code >> 2];
      const int exit = t->CornerOf(third);
      third = t->v[code & 3];
      code = t->opposite[exit];
    }
    const SimplexIndex other = created_[code & ~kRim];
    Link(ToCode(made, i), ToCode(other, tetrahedra_[other].CornerOf(third)));
  }
}

void DelaunayTetrahedralization::InsertAll(std::span<const VertexIndex> indices,
                                           std::span<const Point3> points) {
  assert(indices.size() == points.size());
  if (!indices.empty()) {
    const std::size_t limit = *std::max_element(indices.begin(), indices.end()) + std::size_t{1};
    records_.reserve(limit);
  }
  tetrahedra_.reserve(tetrahedra_.size() + 7 * points.size());
  tags_.reserve(tetrahedra_.size() + 7 * points.size());
  SimplexIndex near = infinite_incident_ >> 2;
  for (const std::uint32_t i : InsertOrder(points)) {
    InsertAt(indices[i], points[i], LocateFrom(points[i], near));
    if (is_full_) return;
    near = created_[0];
  }
  created_.clear();
  deleted_.clear();
  deleted_tags_.clear();
}

}  // namespace dynmesh::delaunay
