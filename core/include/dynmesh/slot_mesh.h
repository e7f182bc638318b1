// A replica of a mesh in arrays whose indices stay: a vertex or simplex keeps its *slot* for as
// long as it lives. Takes diffs in time proportional to the diff, and proves itself equal to the
// original by the hash after each.
//
// An array of a program that has one entry a slot needs no renumbering: an edit frees some slots
// and fills some. What the last diffs did is a *patch*, in slots. Slots that a patch frees are not
// filled again before the next patch begins, so an array may hold old values in them meanwhile:
// that is what dynmesh/transfer.h works on.
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

// A place in an array of the mesh: of a vertex, a simplex, a subsegment or a subfacet.
using Slot = std::int32_t;
inline constexpr Slot kNoSlot = -1;  // the slot of nothing

namespace slot_mesh_internal {
// Memory that nothing has been written to; on large pages if it is large.
std::shared_ptr<void> MakeBlock(std::size_t bytes);
}  // namespace slot_mesh_internal

// One column of a mesh. It grows by moving to a larger block; a block lives as long as it is
// shared, so what was shared before stays readable, but is not updated any more.
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
  // The block that holds the values, for a reader that outlives the column's growth.
  std::shared_ptr<const T[]> share() const { return data_; }

  // Makes room for `capacity` values, so that resize up to there moves nothing.
  void reserve(std::size_t capacity) {
    if (capacity <= capacity_) return;
    std::shared_ptr<T[]> block = MakeBlock(capacity);
    std::copy_n(data_.get(), size_, block.get());
    data_ = std::move(block), capacity_ = capacity;
  }
  // Has `size` values from now on, new ones equal to `value`. Amortised O(new values).
  void resize(std::size_t size, const T& value) {
    if (size > capacity_) reserve(size > 2 * capacity_ ? size : 2 * capacity_);
    if (size > size_) std::fill(data_.get() + size_, data_.get() + size, value);
    size_ = size;
  }

  // No value.
  SlotColumn() = default;
  // A copy of the values of `other` in a block of its own.
  SlotColumn(const SlotColumn& other) : size_(other.size_), capacity_(other.size_) {
    if (size_ == 0) return;
    data_ = MakeBlock(size_);
    std::copy_n(other.data_.get(), size_, data_.get());
  }
  // Takes the block of `other`, which is empty then.
  SlotColumn(SlotColumn&& other) noexcept { swap(other); }
  // Takes the values of `other`, a copy or one that was moved.
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

// What the diffs of one patch did, netted, in slots. Old simplices are given by their corners,
// since their rows are gone; the slots of old vertices keep their coordinates.
// The order of all rows is that of ids, so it is a function of the two meshes alone.
struct MeshPatch {
  std::uint64_t from_revision = 0;         // before the first diff
  std::uint64_t to_revision = 0;           // after the last one
  std::vector<Slot> removed_vertices;      // free now
  std::vector<Slot> added_vertices;        // filled now
  std::vector<Slot> removed_simplices;     // free now
  std::vector<Slot> removed_corners;       // of these, n x (dimension + 1) slots of vertices
  std::vector<RegionId> removed_regions;   // of these
  std::vector<Slot> added_simplices;       // filled now
  std::vector<Slot> relabelled_simplices;  // those in both meshes whose region is another now
  std::vector<RegionId> former_regions;    // of these

  // Is no vertex or simplex another?
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
  // A vertex as FindVertex tells of it.
  struct Vertex {
    std::array<double, 3> coordinates = {0, 0, 0};  // entries past the dimension are 0
    int containing_dimension = 0;                   // as in VertexColumns
    FeatureId owner = kNoFeature;                   // as in VertexColumns
  };

  // A mesh of `dimension` 2 or 3 with no part at all, revision 0, hash 0: what the diff from
  // nothing applies to.
  explicit SlotMesh(int dimension = 2);
  SlotMesh(const SlotMesh& other);
  SlotMesh(SlotMesh&& other) noexcept;
  SlotMesh& operator=(SlotMesh other) noexcept;
  ~SlotMesh();

  // Takes over a whole `mesh` (a snapshot). Slots 0, 1, ... are filled such that what is near in the
  // mesh is near in memory, whatever the order of its rows. O(mesh lg mesh). INVALID_ARGUMENT if the
  // columns of the mesh disagree or its region sets are none; DATA_LOSS if a part stands
  // twice, a simplex has a corner that is absent or mesh.hash is not that of the parts.
  static absl::StatusOr<SlotMesh> FromMesh(const Mesh& mesh);

  // Becomes diff.to_revision and begins a new patch, that of `diff`. O(diff). INVALID_ARGUMENT if
  // its columns disagree or the dimension differs; FAILED_PRECONDITION unless diff.from_revision
  // is revision(); DATA_LOSS if a part to remove is absent (a simplex: in that region), one to add
  // is present or has a corner that is absent, or the hash does not come out as diff.hash.
  absl::Status Apply(const MeshDiff& diff);
  // The same, but `diff` goes on with the patch that there is: it tells the way from where it
  // began to diff.to_revision. O(diff and patch).
  absl::Status Extend(const MeshDiff& diff);

  // Of the diffs since the last Apply, that one included.
  const MeshPatch& patch() const;

  // The whole mesh, O(size). Rows in no particular order.
  Mesh ToMesh() const;
  // Numbers of what is there, without gaps, O(slots).
  CompactNumbering Compact() const;

  int dimension() const;                 // 2 or 3
  std::uint64_t revision() const;        // to_revision of the last diff
  MeshHash hash() const;                 // of what is held
  std::size_t vertex_count() const;      // slots in use
  std::size_t simplex_count() const;     // slots in use
  std::size_t subsegment_count() const;  // slots in use
  std::size_t subfacet_count() const;    // slots in use

  // Columns by slot of a vertex. Free ones have id 0, and of the rest what they had.

  const SlotColumn<double>& points() const;                       // slots x dimension
  const SlotColumn<VertexId>& ids() const;                        // 0 where the slot is free
  const SlotColumn<std::uint8_t>& containing_dimensions() const;  // as in VertexColumns
  const SlotColumn<FeatureId>& owners() const;                    // as in VertexColumns

  // Columns by slot of a simplex.

  // Slots of the dimension + 1 corners in canonical order; all -1 where the slot is free.
  const SlotColumn<Slot>& cells() const;
  // The simplex across the face opposite of each corner; -1 at the border of the mesh, or of the
  // part that is held.
  const SlotColumn<Slot>& neighbours() const;
  const SlotColumn<RegionId>& regions() const;  // kNoRegion: in no polygon
  // Is any simplex in a region?
  bool has_regions() const;

  // Columns by slot of a subsegment or subfacet.

  const SlotColumn<Slot>& subsegments() const;  // slots of ends, -1 where it is free: slots x 2
  const SlotColumn<FeatureId>& subsegment_owners() const;  // the feature of each
  const SlotColumn<Slot>& subfacets() const;  // slots of corners, -1 where it is free: slots x 3
  const SlotColumn<FeatureId>& subfacet_owners() const;  // the feature of each
  // The sets of several polygons that `regions` names, by id. O(sets lg sets).
  std::vector<RegionSet> region_sets() const;

  // Each of these takes expected O(1).

  // The slot of the vertex `id`; kNoSlot if it is absent.
  Slot FindSlot(VertexId id) const;
  // The slot of the simplex with these vertex `ids` in canonical order; kNoSlot if it is absent.
  Slot FindSimplexSlot(std::span<const VertexId> ids) const;
  // The vertex `id`; nothing if it is absent.
  std::optional<Vertex> FindVertex(VertexId id) const;
  // Is there a simplex with these vertex `ids`, in canonical order?
  bool HasSimplex(std::span<const VertexId> ids) const;
  // The region of the simplex with these vertex `ids` in canonical order; nothing if it is absent.
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
