// Removal of a vertex v. Its star is removed, and the hole is filled.
// 1. What fills the hole are tetrahedra that v would delete: inserting v would restore the star.
// 2. They are empty of all vertices, and their corners are on the hole's surface, the link of v. So
//    they occur in the tetrahedralisation of the link's vertices alone.
// 3. There they are all that v deletes, since the star occurs in that of the link and v, too.
// 4. So the link is tetrahedralised by itself, and what conflicts with v is copied into the hole.
//    If v was on a face of the box, kInfinite is in its link, and infinite tetrahedra are copied
//    like others.
#include <algorithm>
#include <cassert>
#include <utility>

#include "core/delaunay/delaunay_insert_order.h"
#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::delaunay {

using geometry::Point3;

namespace {

// Up to so many vertices of a link are inserted in the given order.
constexpr std::size_t kSmallLink = 64;

std::array<std::uint32_t, 3> Sorted(std::array<std::uint32_t, 3> facet) {
  if (facet[0] > facet[1]) std::swap(facet[0], facet[1]);
  if (facet[1] > facet[2]) std::swap(facet[1], facet[2]);
  if (facet[0] > facet[1]) std::swap(facet[0], facet[1]);
  return facet;
}

}  // namespace

struct DelaunayTetrahedralization::Hole {
  Star star;
  NumberTable<3> facets;      // of the surface, by sorted vertices, in the order of the star
  std::vector<Code> outside;  // by number of facet: the corner beyond
  NumberTable<1> vertices;    // of the link, finite ones: the numbers are vertices of `link`
  DelaunayTetrahedralization link;
};

void DelaunayTetrahedralization::DeleteHole::operator()(Hole* hole) const { delete hole; }

void DelaunayTetrahedralization::Remove(VertexIndex v) {
  assert(Contains(v));
  assert(std::find(corners_.begin(), corners_.end(), v) == corners_.end());
  if (hole_ == nullptr) hole_.reset(new Hole);
  Hole& hole = *hole_;
  hole.link.most_simplices_ = most_simplices_;
  SimplicesAround(v, &hole.star);
  hole.facets.Clear();
  hole.outside.clear();
  hole.vertices.Clear();
  for (const auto [t] : hole.star.keys()) {
    const Tetrahedron& tetrahedron = tetrahedra_[t];
    const int corner = tetrahedron.CornerOf(v);
    const auto& [i, j, k] = kFacet[corner];
    const std::array<VertexIndex, 3> facet = {tetrahedron.v[i], tetrahedron.v[j], tetrahedron.v[k]};
    hole.facets.Number(Sorted(facet));
    hole.outside.push_back(tetrahedron.opposite[corner]);
    for (const VertexIndex u : facet) {
      if (u != kInfinite) hole.vertices.Number({u});
    }
  }
  TriangulateLink(v);
  const std::size_t fresh = hole.link.cavity_.size(), gone = hole.star.keys().size();
  if (hole.link.is_full_ || (fresh > gone && Overflows(fresh - gone))) {
    is_full_ = true;
    return;
  }
  cavity_.clear();
  for (const auto [t] : hole.star.keys()) cavity_.push_back(t);
  Delete(cavity_);
  records_[v].incident = kNone;
  --vertex_count_;
  FillHole();
}

// Tetrahedralises the vertices of v's link into hole_->link. Its cavity_ becomes what v deletes.
void DelaunayTetrahedralization::TriangulateLink(VertexIndex v) {
  DelaunayTetrahedralization& link = hole_->link;
  const auto vertices = hole_->vertices.keys();
  const auto count = static_cast<std::uint32_t>(vertices.size());
  const auto point_of = [&](VertexIndex i) -> const Point3& {
    return records_[vertices[i][0]].point;
  };
  // Starts from a finite tetrahedron of v, with v replaced by another vertex off the plane of the
  // opposite facet.
  const auto star = hole_->star.keys();
  const auto finite =
      std::find_if(star.begin(), star.end(), [&](const auto& t) { return !IsInfinite(t[0]); });
  assert(finite != star.end());
  const Tetrahedron& t = tetrahedra_[(*finite)[0]];
  const auto& [i, j, k] = kFacet[t.CornerOf(v)];
  std::array<VertexIndex, 4> first = {hole_->vertices.Find({t.v[i]}),
                                      hole_->vertices.Find({t.v[j]}),
                                      hole_->vertices.Find({t.v[k]}), 0};
  int side = 0;
  for (VertexIndex u = 0; side == 0; ++u) {
    if (u == first[0] || u == first[1] || u == first[2]) continue;
    assert(u < count);
    side = geometry::Orientation(point_of(first[0]), point_of(first[1]), point_of(first[2]),
                                 point_of(u));
    first[3] = u;
  }
  if (side < 0) std::swap(first[0], first[1]);
  link.StartFrom(first,
                 {point_of(first[0]), point_of(first[1]), point_of(first[2]), point_of(first[3])});

  SimplexIndex near = 0;
  const auto insert = [&](VertexIndex u) {
    if (link.is_full_ || link.Contains(u)) return;
    link.InsertAt(u, point_of(u), link.LocateFrom(point_of(u), near));
    if (!link.is_full_) near = link.created_[0];
  };
  if (count <= kSmallLink) {
    for (VertexIndex u = 0; u < count; ++u) insert(u);
  } else {
    std::vector<Point3> points;
    for (VertexIndex u = 0; u < count; ++u) points.push_back(point_of(u));
    for (const VertexIndex u : InsertOrder(points)) insert(u);
  }
  if (link.is_full_) return;
  link.FindCavity(records_[v].point, link.LocateFrom(records_[v].point, near));
}

void DelaunayTetrahedralization::FillHole() {
  const DelaunayTetrahedralization& link = hole_->link;
  const auto to_vertex = [&](VertexIndex u) {
    return u == kInfinite ? kInfinite : hole_->vertices.keys()[u][0];
  };
  // The tag is the index in link.cavity_, which is also the index in created_.
  Allocate(link.cavity_.size());
  for (std::uint32_t n = 0; n < created_.size(); ++n) hole_->link.set_tag(link.cavity_[n], n);
  assert(link.rim_.size() == hole_->outside.size());
  for (std::size_t n = 0; n < link.cavity_.size(); ++n) {
    const Tetrahedron& source = link.tetrahedra_[link.cavity_[n]];
    const SimplexIndex t = created_[n];
    Make(t, {to_vertex(source.v[0]), to_vertex(source.v[1]), to_vertex(source.v[2]),
             to_vertex(source.v[3])});
    Tetrahedron& copy = tetrahedra_[t];
    for (int i = 0; i < 4; ++i) {
      const Code code = source.opposite[i];
      if ((code & kRim) == 0) {
        copy.opposite[i] = ToCode(created_[link.tag(code >> 2)], static_cast<int>(code & 3));
        continue;
      }
      const auto& [a, b, c] = kFacet[i];
      const std::uint32_t facet = hole_->facets.Find(Sorted({copy.v[a], copy.v[b], copy.v[c]}));
      assert(facet < hole_->outside.size());
      Link(ToCode(t, i), hole_->outside[facet]);
    }
  }
}

std::size_t DelaunayTetrahedralization::bytes() const {
  std::size_t sum =
      tetrahedra_.capacity() * sizeof(Tetrahedron) + tags_.capacity() * sizeof(std::uint64_t) +
      records_.capacity() * sizeof(VertexRecord) + free_.capacity() * sizeof(SimplexIndex) +
      created_.capacity() * sizeof(SimplexIndex) +
      deleted_.capacity() * (sizeof(deleted_[0]) + sizeof(deleted_tags_[0])) +
      cavity_.capacity() * sizeof(SimplexIndex) + rim_.capacity() * sizeof(RimFacet);
  if (hole_ != nullptr) {
    sum += hole_->star.bytes() + hole_->facets.bytes() + hole_->outside.capacity() * sizeof(Code) +
           hole_->vertices.bytes() + hole_->link.bytes();
  }
  return sum;
}

}  // namespace dynmesh::delaunay
