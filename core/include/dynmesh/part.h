// The part of a mesh that lies in chosen polygons, without gaps, kept up to date by diffs: the mesh
// of a simulation's domain. The whole mesh reaches far beyond its features.
//
//   auto mesh = dynmesh::SlotMesh::FromMesh(snapshot);                 // check mesh.ok()
//   dynmesh::MeshPart part(*mesh, {.polygons = {7}});                  // or .inside = true
//   if (mesh->Apply(diff).ok()) status = part.Update(*mesh, {&diff, 1});
//
// Vertices, cells (triangles or tetrahedra) and facets (edges or faces) have numbers 0, 1, ... in
// the part. An update keeps the numbers of what stays, except that the last ones fill the gaps.
// Facets are the part's border and the subsegments (3D: subfacets) in it.
//
// A part may be *opened* along features, as cracks are:
//
//   dynmesh::MeshPart plate(*mesh, {.polygons = {7}, .open = {20, 21}});
//
// A vertex on them has a copy for each sector of the part's cells around it: cells connected
// through facets that are not opened. So the tip of a crack (3D: its front) stays closed, a branch
// has three copies, and a mouth at the part's border is open. Each side has a facet of its own. A
// copy keeps its number while one of its cells stays.
//
// Thread-compatible. Copies are deep.
#ifndef DYNMESH_PART_H_
#define DYNMESH_PART_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh {

// Which cells are in the part: those in one of `polygons` or of the polygons with one of `names`
// and in none of `without`. In 3D a polygon stands for the closed surface that has its id
// (RegionId).
struct PartChoice {
  std::vector<FeatureId> polygons = {};  // by id
  std::vector<std::string> names = {};   // by the names of their labels
  bool inside = false;                   // all polygons that there are
  std::vector<FeatureId> without = {};   // by id
  // Segments and polygons that are opened, by id: in 2D along the subsegments that they own
  // (VertexColumns), in 3D along their subfacets.
  std::vector<FeatureId> open = {};
  std::vector<std::string> open_names = {};  // and by the names of their labels
};

// The part; see part.h.
class MeshPart {
 public:
  // The part of `mesh` by the `choice`. A whole mesh: not the replica of a watch of some regions.
  // Numbers are by ascending slot. O(mesh).
  MeshPart(const SlotMesh& mesh, PartChoice choice);
  MeshPart(const MeshPart& other);
  MeshPart(MeshPart&& other) noexcept;
  MeshPart& operator=(MeshPart other) noexcept;
  ~MeshPart();

  // Follows `mesh` after `diffs`: those of its last Apply and of the Extends since. Expected
  // O(diffs + patch); O(mesh) if the polygons with one of the names are others now, or a feature
  // that stays gets or loses a name that is opened. FAILED_PRECONDITION if the mesh's patch is not
  // that from revision() on, or `diffs` do not lead there. An error changes nothing.
  absl::Status Update(const SlotMesh& mesh, std::span<const MeshDiff* const> diffs);

  // The part as a mesh of its own, with its subsegments and subfacets, the region sets and labels
  // of the whole and the hash of the part. Where it is opened each copy is a vertex, one with
  // the mesh's id, others with ids that no vertex has; each side has its subsegments and
  // subfacets, but one where no corner has copies. That is for files: it is no Delaunay mesh.
  // O(mesh). FAILED_PRECONDITION if `mesh` is not at revision().
  absl::StatusOr<Mesh> ToMesh(const SlotMesh& mesh) const;

  int dimension() const;           // 2 or 3
  std::uint64_t revision() const;  // of the mesh that it is of

  // By vertex of the part.

  const SlotColumn<double>& points() const;      // coordinates: vertices x dimension
  const SlotColumn<Slot>& vertex_slots() const;  // its slot in the mesh
  // The number of the first copy of the vertex; its own where it is that, or the only one.
  const SlotColumn<std::int32_t>& origin() const;

  // By cell of the part.

  // Numbers of the corners, positively oriented: cells x (dimension + 1).
  const SlotColumn<std::int32_t>& cells() const;
  const SlotColumn<Slot>& cell_slots() const;        // its slot in the mesh
  const SlotColumn<RegionId>& cell_regions() const;  // its region

  // The cells around any of these `vertices`, ascending, each once. Expected O(cells around them).
  // FAILED_PRECONDITION if `mesh` is not at revision(); OUT_OF_RANGE for a number that no vertex
  // has.
  absl::StatusOr<std::vector<std::int32_t>> CellsAround(
      const SlotMesh& mesh, std::span<const std::int32_t> vertices) const;

  // By facet of the part.

  // Numbers of the corners: facets x dimension. At the border the part is on the left (3D: below
  // the facet, whose corners are counter-clockwise as seen from outside); else of its first cell.
  const SlotColumn<std::int32_t>& facets() const;
  // As in SubsegmentColumns; kNoFeature: none.
  const SlotColumn<FeatureId>& facet_owners() const;
  // The slots of the part's cells at the facet: facets x 2. The second one is kNoSlot at the
  // border, and where the part is opened.
  const SlotColumn<Slot>& facet_cells() const;
  // The facet of the other side, where the part is opened between two of its cells; else -1.
  const SlotColumn<std::int32_t>& facet_twins() const;
  // The side of each facet of an opened feature: 1 if the part's cell there is on the left of a
  // segment, as it goes from its first end to its second one; in a polygon of 2D; or in 3D on the
  // side from which the polygon's first ring is counter-clockwise. Else -1. 0 for all other facets.
  // `features`: those that are opened, and their points; others may be among them, and features
  // that are missing have 0. O(facets + features). FAILED_PRECONDITION if `mesh` is not at
  // revision().
  absl::StatusOr<std::vector<std::int8_t>> FacetSides(const SlotMesh& mesh,
                                                      std::span<const Feature> features) const;

  // By slot of the mesh: the number in the part; -1 where it is not in it.

  const SlotColumn<std::int32_t>& vertex_numbers() const;  // by slot of a vertex: its first copy
  const SlotColumn<std::int32_t>& cell_numbers() const;    // by slot of a simplex

  // The rows that the last Update has written, each once or more. Those behind the former end may
  // be missing, and some may be behind the present one.
  struct Changes {
    bool is_all = true;                  // all rows: of a new part, and after an O(mesh) update
    std::vector<std::int32_t> vertices;  // of points(), vertex_slots() and origin()
    std::vector<std::int32_t> cells;     // of cells(), cell_slots() and cell_regions()
    std::vector<std::int32_t> facets;    // of facets(), facet_owners(), _cells() and _twins()
    std::vector<Slot> vertex_slots;      // of vertex_numbers()
    std::vector<Slot> cell_slots;        // of cell_numbers()
  };
  // What the last Update has changed.
  const Changes& changes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace dynmesh

#endif  // DYNMESH_PART_H_
