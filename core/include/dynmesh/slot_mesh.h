// A replica of a mesh in arrays with stable indices: a vertex or simplex keeps its *slot* while it
// exists. Applies diffs in time proportional to the diff. Checks the hash after each.
//
//   auto mesh = dynmesh::SlotMesh::FromMesh(snapshot);  // check mesh.ok()
//   absl::Status status = mesh->Apply(diff);            // now at diff.to_revision
//   for (dynmesh::Slot s : mesh->patch().added_simplices) Use(mesh->cells().data() + 3 * s);  // 2D
//
// An application's array with one entry a slot needs no renumbering: an edit frees some slots and
// fills some. The changes of the last diffs are a *patch*, in slots. Slots that a patch frees are
// filled only after the next patch begins. So an array may keep old values in them meanwhile, as
// dynmesh/transfer.h needs.
//
// Invariants:
//   1. hash() is the sum of the hashes of the rows held (ComputeHash);
//   2. each id, simplex, subsegment and subfacet has one slot; region sets are held while in use;
//   3. a call that returns an error has changed nothing.
//
// Thread-compatible. Copies are deep.
#ifndef DYNMESH_SLOT_MESH_H_
#define DYNMESH_SLOT_MESH_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

// An index into the arrays of vertices, simplices, subsegments or subfacets.
using Slot = std::int32_t;
inline constexpr Slot kNoSlot = -1;  // the slot of nothing

namespace slot_mesh_internal {
// Uninitialized memory of `bytes`; on huge pages if it is large.
std::shared_ptr<void> MakeBlock(std::size_t bytes);
}  // namespace slot_mesh_internal

// One column of a mesh. It grows by moving to a larger block. A block lives as long as it is
// shared: it stays readable after the column has moved, but is not updated any more.
template <class T>
class SlotColumn {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  std::size_t size() const { return size_; }  // the number of values
  // The value at `i`, which is below size().
  const T& operator[](std::size_t i) const { return data_[i]; }
  // The same, to be changed.
  T& operator[](std::size_t i) { return data_[i]; }
  // The first value; valid until the column grows.
  const T* data() const { return data_.get(); }
  // The same, to be changed.
  T* data() { return data_.get(); }
  // All values; valid until the column grows.
  std::span<const T> span() const { return {data_.get(), size_}; }
  // The block that holds the values, for a reader that keeps it while the column grows.
  std::shared_ptr<const T[]> share() const { return data_; }

  // Allocates room for `capacity` values: resize up to there moves nothing.
  void reserve(std::size_t capacity) {
    if (capacity <= capacity_) return;
    std::shared_ptr<T[]> block = MakeBlock(capacity);
    std::copy_n(data_.get(), size_, block.get());
    data_ = std::move(block), capacity_ = capacity;
  }
  // Changes the size to `size`; new values are equal to `value`. Amortised O(new values).
  void resize(std::size_t size, const T& value) {
    if (size > capacity_) reserve(size > 2 * capacity_ ? size : 2 * capacity_);
    if (size > size_) std::fill(data_.get() + size_, data_.get() + size, value);
    size_ = size;
  }

  // An empty column.
  SlotColumn() = default;
  // A copy of the values of `other` in its own block.
  SlotColumn(const SlotColumn& other) : size_(other.size_), capacity_(other.size_) {
    if (size_ == 0) return;
    data_ = MakeBlock(size_);
    std::copy_n(other.data_.get(), size_, data_.get());
  }
  // Takes the block of `other`, which is then empty.
  SlotColumn(SlotColumn&& other) noexcept { swap(other); }
  // Takes the values of `other` (a copy or a moved column).
  SlotColumn& operator=(SlotColumn other) noexcept {
    swap(other);
    return *this;
  }
  ~SlotColumn() = default;
  // Exchanges values with `other`. O(1).
  void swap(SlotColumn& other) noexcept {
    data_.swap(other.data_);
    std::swap(size_, other.size_), std::swap(capacity_, other.capacity_);
  }

 private:
  static std::shared_ptr<T[]> MakeBlock(std::size_t count) {
    std::shared_ptr<void> block = slot_mesh_internal::MakeBlock(count * sizeof(T));
    T* const begin = static_cast<T*>(block.get());
    return std::shared_ptr<T[]>(std::move(block), begin);
  }

  std::shared_ptr<T[]> data_;
  std::size_t size_ = 0, capacity_ = 0;
};

// The net change by the diffs of one patch, in slots. Removed simplices are given by their corners,
// since their rows are cleared. The slots of removed vertices keep their coordinates. All rows are
// in the order of ids, so a patch is a function of the two meshes alone.
struct MeshPatch {
  std::uint64_t from_revision = 0;         // before the first diff
  std::uint64_t to_revision = 0;           // after the last one
  std::vector<Slot> removed_vertices;      // now free
  std::vector<Slot> added_vertices;        // now filled
  std::vector<Slot> removed_simplices;     // now free
  std::vector<Slot> removed_corners;       // of these: n x (dimension + 1) slots of vertices
  std::vector<RegionId> removed_regions;   // of these
  std::vector<Slot> added_simplices;       // now filled
  std::vector<Slot> relabelled_simplices;  // in both meshes, with different regions
  std::vector<RegionId> former_regions;    // of these, before

  // Are the vertices, simplices and regions unchanged?
  bool empty() const {
    return removed_vertices.empty() && added_vertices.empty() && removed_simplices.empty() &&
           added_simplices.empty() && relabelled_simplices.empty();
  }
};

// A numbering of the vertices and simplices without gaps, by ascending slot.
struct CompactNumbering {
  std::vector<Slot> vertex_slots;             // of vertex 0, 1, ...
  std::vector<std::int32_t> vertex_numbers;   // of each slot; -1 where it is free
  std::vector<Slot> simplex_slots;            // of simplex 0, 1, ...
  std::vector<std::int32_t> simplex_numbers;  // of each slot; -1 where it is free
};

// The replica; see slot_mesh.h.
class SlotMesh {
 public:
  // A vertex as returned by FindVertex.
  struct Vertex {
    std::array<double, 3> coordinates = {0, 0, 0};  // entries past the dimension are 0
    int containing_dimension = 0;                   // as in VertexColumns
    FeatureId owner = kNoFeature;                   // as in VertexColumns
  };

  // An empty mesh of `dimension` 2 or 3, revision 0, hash 0. The diff from nothing applies to it.
  explicit SlotMesh(int dimension = 2);
  SlotMesh(const SlotMesh& other);
  SlotMesh(SlotMesh&& other) noexcept;
  SlotMesh& operator=(SlotMesh other) noexcept;
  ~SlotMesh();

  // Makes a replica of a whole `mesh` (a snapshot). Fills slots 0, 1, ... such that neighbours in
  // the mesh are near in memory, whatever the order of rows. O(n lg n) for n rows. INVALID_ARGUMENT
  // if columns disagree, region sets are invalid or there are 2^31 rows or more. DATA_LOSS if a
  // part occurs twice, a simplex has an unknown corner, or mesh.hash is not the sum of its parts.
  static absl::StatusOr<SlotMesh> FromMesh(const Mesh& mesh);

  // Applies `diff`: the mesh is then at diff.to_revision, and patch() is that of `diff` alone.
  // O(diff). INVALID_ARGUMENT if its columns disagree or the dimension differs. FAILED_PRECONDITION
  // if diff.from_revision is not revision(). DATA_LOSS if a removed part is absent (a simplex: in
  // that region), an added one is present or has an unknown corner, or the result's hash is not
  // diff.hash. An error changes nothing.
  absl::Status Apply(const MeshDiff& diff);
  // The same, but extends the current patch by `diff`: patch() then leads from where it began to
  // diff.to_revision. O(diff + patch). Errors as of Apply.
  absl::Status Extend(const MeshDiff& diff);

  // The net change since before the last Apply.
  const MeshPatch& patch() const;

  // The whole mesh, O(size). Rows in no particular order.
  Mesh ToMesh() const;
  // Numbers vertices and simplices without gaps, O(slots).
  CompactNumbering Compact() const;

  int dimension() const;                 // 2 or 3
  std::uint64_t revision() const;        // to_revision of the last diff
  MeshHash hash() const;                 // of the mesh held
  std::size_t vertex_count() const;      // slots in use
  std::size_t simplex_count() const;     // slots in use
  std::size_t subsegment_count() const;  // slots in use
  std::size_t subfacet_count() const;    // slots in use

  // Columns by slot of a vertex. In free slots the id is 0, the others keep their last values.

  const SlotColumn<double>& points() const;                       // slots x dimension
  const SlotColumn<VertexId>& ids() const;                        // 0 where the slot is free
  const SlotColumn<std::uint8_t>& containing_dimensions() const;  // as in VertexColumns
  const SlotColumn<FeatureId>& owners() const;                    // as in VertexColumns

  // Columns by slot of a simplex.

  // Slots of the dimension + 1 corners in canonical order; all -1 where the slot is free.
  const SlotColumn<Slot>& cells() const;
  // The simplex across the face opposite to each corner; -1 at the border of the mesh or of the
  // part that is held.
  const SlotColumn<Slot>& neighbours() const;
  const SlotColumn<RegionId>& regions() const;  // kNoRegion: in no polygon
  // Is any simplex in a region?
  bool has_regions() const;

  // Columns by slot of a subsegment or subfacet.

  const SlotColumn<Slot>& subsegments() const;             // slots of ends, -1 if free: slots x 2
  const SlotColumn<FeatureId>& subsegment_owners() const;  // the feature of each
  const SlotColumn<Slot>& subfacets() const;             // slots of corners, -1 if free: slots x 3
  const SlotColumn<FeatureId>& subfacet_owners() const;  // the feature of each
  // The sets of several polygons that regions() names, by id. O(sets lg sets).
  std::vector<RegionSet> region_sets() const;
  // The labels of features, by id: as Mesh::labels. O(labels).
  LabelColumn labels() const;
  // The label of the feature `id`; an empty one if it has none. O(lg labels).
  FeatureLabel FindLabel(FeatureId id) const;

  // Each of the following takes expected O(1).

  // The slot of the vertex `id`; kNoSlot if absent.
  Slot FindSlot(VertexId id) const;
  // The slot of the simplex with these vertex `ids` in canonical order; kNoSlot if absent.
  Slot FindSimplexSlot(std::span<const VertexId> ids) const;
  // The vertex `id`; nothing if absent.
  std::optional<Vertex> FindVertex(VertexId id) const;
  // Is there a simplex with these vertex `ids`, in canonical order?
  bool HasSimplex(std::span<const VertexId> ids) const;
  // The region of the simplex with these vertex `ids` in canonical order; nothing if absent.
  std::optional<RegionId> FindRegion(std::span<const VertexId> ids) const;
  // Is there a subsegment of `owner` with the ends `a` and `b`, in any order?
  bool HasSubsegment(VertexId a, VertexId b, FeatureId owner) const;
  // Is there a subfacet of `owner` with these `corners`, in any order?
  bool HasSubfacet(const std::array<VertexId, 3>& corners, FeatureId owner) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace dynmesh

#endif  // DYNMESH_SLOT_MESH_H_
