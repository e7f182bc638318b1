// The slivers: tetrahedra of the refined mesh with a dihedral angle below the bound. Cure (cure.h)
// works on them. An angle opposite to an excused edge does not count: that edge is as short as a
// small angle of the input makes it (shells.h), and so is the angle. A sliver by such angles alone
// is *exempt*, and so is a tetrahedron between counterparts (sharp_facets.h), which may be flat by
// construction. Exempt ones may stay, but most can be cured.
//
// *Base*: the triangulation of the vertices that refinement made, without those of cures. It is a
// function of the vertex set, so it stands outside the trace. Between refinement and cures it is
// brought up to date, and slivers that came and went are found. A sliver stays the same item while
// its tetrahedron exists.
//
// Thread-compatible. O(tetrahedra that come and go) per update.
#ifndef DYNMESH_CORE_MESHING_SLIVER_TABLE_H_
#define DYNMESH_CORE_MESHING_SLIVER_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/functional/function_ref.h"
#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/geometry/circumball.h"
#include "core/geometry/dihedral.h"
#include "core/geometry/point.h"
#include "core/meshing/elements.h"
#include "core/sac/engine.h"

namespace dynmesh::meshing {

using SliverIndex = std::uint32_t;

// In degrees. Symmetric input and facets off the coordinate planes make tetrahedra with four
// corners on a circle, within rounding. They are cured even if slivers may stay: the entries of a
// finite-element matrix grow as the cotangent.
inline constexpr double kFlat = 0.01;

struct Sliver {
  std::array<VertexIndex, 4> v = {};  // sorted by position
  std::uint32_t simplex = 0;          // of the base
  std::uint64_t hash = 0;             // of the positions
  geometry::Point3 centre = {};       // of the circumscribed ball
  double radius = 0;
  // The unit normal of the plane near which its corners lie, nearly on a circle. For a thin one,
  // with corners nearly on a line: some direction across the line.
  geometry::Vector3 normal = {};
  double shortest2 = 0;  // squared length of its shortest edge
  sac::OpId operations = sac::kNoOp;
  bool is_exempt = false;
  bool is_there = false;    // in the base
  bool is_asked = false;    // a cure is requested
  bool is_touched = false;  // stands in the list of changes
};

class SliverTable {
 public:
  using Base = delaunay::DelaunayTetrahedralization;
  using Point = geometry::Point3;
  using IsExcused = absl::FunctionRef<bool(VertexIndex, VertexIndex)>;
  using IsFlat = absl::FunctionRef<bool(const std::array<VertexIndex, 4>&)>;

  // `degrees`: the bound. 0: there are no slivers.
  explicit SliverTable(double degrees) : bound_(degrees) {}

  bool is_on() const { return bound_.degrees() > 0; }
  const geometry::DihedralBound& bound() const { return bound_; }
  const Base& base() const { return *base_; }
  // These tetrahedra of the base, by index, are no slivers, and angles of new ones in their place
  // do not matter. Call before Begin, of a base that does not change.
  void SetOutside(std::vector<bool> outside) { outside_ = std::move(outside); }
  bool IsOutside(std::uint32_t simplex) const { return !outside_.empty() && outside_[simplex]; }
  bool has_base() const { return base_ != nullptr; }
  const Sliver& operator[](SliverIndex i) const { return slivers_[i]; }
  sac::OpId& operations(SliverIndex i) { return slivers_[i].operations; }
  std::size_t bytes() const { return own_.bytes() + slivers_.capacity() * sizeof(Sliver); }

  // The base is `whole`, which must not change while it is used; if is_to_change, a copy of it.
  // `interrupt` is called now and then; returns false if it returns true.
  // is_excused(v, u): of an edge. is_flat(v): of a tetrahedron, by its corners; then it is exempt.
  // Functions of the vertices.
  bool Begin(const Base& whole, bool is_to_change, IsExcused is_excused, IsFlat is_flat,
             absl::FunctionRef<bool()> interrupt);

  // Changes one vertex of the base. REQUIRES: the base is a copy.
  void Remove(VertexIndex v);
  void Insert(VertexIndex v, const Point& p, VertexIndex near);
  // Finds the slivers among changed tetrahedra.
  void FindSlivers(IsExcused is_excused, IsFlat is_flat);
  // Does the tetrahedron have an angle below the bound that counts? `v`: its corners, kNil for one
  // without excused edges; `p`: their positions.
  bool IsSliver(std::array<VertexIndex, 4> v, std::array<Point, 4> p, IsExcused is_excused) const;
  // What is certain of a tetrahedron, of which corner 3 is no vertex yet: no angle is below the
  // bound; or one is, and counts. Mostly one of the two is.
  geometry::DihedralBound::Certain Look(const std::array<Point, 4>& p) const;

  // Calls ask(i) for slivers that came and drop(i) for slivers that went since the last call.
  template <class Ask, class Drop>
  void TakeChanges(Ask ask, Drop drop);
  // Forgets slivers that went. REQUIRES: they have no operations left.
  void Forget();

 private:
  void Look(std::uint32_t simplex, IsExcused is_excused, IsFlat is_flat);
  void RecordChanges();
  void Touch(SliverIndex i);
  SliverIndex Find(const std::array<VertexIndex, 4>& v);

  geometry::DihedralBound bound_;
  const Base* base_ = nullptr;
  Base own_;
  std::vector<bool> outside_;  // by tetrahedron; empty: none is
  std::vector<Sliver> slivers_;
  std::vector<SliverIndex> free_, touched_;
  std::vector<std::uint32_t> fresh_;  // tetrahedra of the base just made
  absl::flat_hash_map<std::array<VertexIndex, 4>, SliverIndex> leaving_;
};

template <class Ask, class Drop>
void SliverTable::TakeChanges(Ask ask, Drop drop) {
  for (const SliverIndex i : touched_) {
    Sliver& sliver = slivers_[i];
    sliver.is_touched = false;
    if (sliver.is_there && !sliver.is_asked) ask(i);
    if (!sliver.is_there && sliver.is_asked) drop(i);
    sliver.is_asked = sliver.is_there;
  }
  touched_.clear();
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SLIVER_TABLE_H_
