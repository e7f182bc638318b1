// The tetrahedra of the refined mesh that have a dihedral angle below the bound: what Cure
// (cure.h) works on.
//
// *Base*: the triangulation of the vertices that refinement made, without those of cures. It is a
// function of the vertex set, so it stands outside the trace: between refinement and cures it
// is brought up to date, and the slivers of what came and went are found. A sliver stays the
// same item as long as its tetrahedron is there.
//
// Thread-compatible. O(tetrahedra that come and go) an update.
#ifndef DYNMESH_CORE_MESHING_SLIVER_TABLE_H_
#define DYNMESH_CORE_MESHING_SLIVER_TABLE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/functional/function_ref.h"
#include "core/geometry/circumball.h"
#include "core/geometry/dihedral.h"
#include "core/geometry/point.h"
#include "core/mesh/delaunay_tetrahedralization.h"
#include "core/meshing/elements.h"
#include "core/sac/engine.h"

namespace dynmesh::meshing {

using SliverIndex = std::uint32_t;

// In degrees. Symmetric input and facets that are no coordinate planes make tetrahedra of four
// corners that lie on a circle but for rounding. They are cured even if slivers may stay: the
// entries of a finite-element matrix grow as the cotangent.
inline constexpr double kFlat = 0.01;

struct Sliver {
  std::array<VertexIndex, 4> v = {};  // by place
  std::uint32_t simplex = 0;          // of the base
  std::uint64_t hash = 0;             // of the places
  geometry::Point3 centre = {};       // of the circumscribed ball
  double radius = 0;
  // Its corners are nearly on a circle: the unit normal of that plane. Of a thin one with corners
  // nearly on a line, some direction across.
  geometry::Vector3 normal = {};
  double shortest2 = 0;  // squared length of its shortest edge
  sac::OpId operations = sac::kNoOp;
  bool is_there = false;    // in the base
  bool is_asked = false;    // a cure is requested
  bool is_touched = false;  // stands in the list of changes
};

class SliverTable {
 public:
  using Base = mesh::DelaunayTetrahedralization;
  using Point = geometry::Point3;

  // `degrees`: the bound, 0: there are no slivers.
  explicit SliverTable(double degrees) : bound_(degrees) {}

  bool is_on() const { return bound_.degrees() > 0; }
  const geometry::DihedralBound& bound() const { return bound_; }
  const Base& base() const { return *base_; }
  bool has_base() const { return base_ != nullptr; }
  const Sliver& operator[](SliverIndex i) const { return slivers_[i]; }
  sac::OpId& operations(SliverIndex i) { return slivers_[i].operations; }
  std::size_t bytes() const { return own_.bytes() + slivers_.capacity() * sizeof(Sliver); }

  // The base is `whole`, which stays what it is while it is used; or, if it is to change
  // later, a copy of it. `interrupt` is asked now and then; false if it says true.
  bool Begin(const Base& whole, bool is_to_change, absl::FunctionRef<bool()> interrupt);

  // The base loses and gets these vertices. REQUIRES: the base is a copy.
  void Remove(VertexIndex v);
  void Insert(VertexIndex v, const Point& p, VertexIndex near);
  // Finds the slivers of what was changed.
  void FindSlivers();

  // Calls ask(i) for slivers that came and drop(i) for those that went since the last call.
  template <class Ask, class Drop>
  void TakeChanges(Ask ask, Drop drop);
  // No operation is left of slivers that went.
  void Forget();

 private:
  void Look(std::uint32_t simplex);
  void RecordChanges();
  void Touch(SliverIndex i);
  SliverIndex Find(const std::array<VertexIndex, 4>& v);

  geometry::DihedralBound bound_;
  const Base* base_ = nullptr;
  Base own_;
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
