#include "client/python/module/shared_mesh.h"

#include <algorithm>
#include <utility>

namespace dynmesh::python {
namespace {

std::size_t At(Slot slot) { return static_cast<std::size_t>(slot); }

// A log that names more rows than this is no better than a copy of the column.
std::size_t MostRows(std::size_t slots) { return std::max<std::size_t>(1024, slots / 4); }

void Append(const std::vector<Slot>& slots, std::vector<Slot>& rows) {
  rows.insert(rows.end(), slots.begin(), slots.end());
}

void AppendCells(const MeshPatch& patch, std::vector<Slot>& rows) {
  Append(patch.removed_simplices, rows);
  Append(patch.added_simplices, rows);
  Append(patch.relabelled_simplices, rows);
}

// The simplices in `ids` and those beside them.
void AppendWithNeighbours(const SlotMesh& mesh, const SimplexColumn& ids, std::vector<Slot>& rows) {
  const auto width = static_cast<std::size_t>(mesh.dimension() + 1);
  for (std::size_t i = 0; i + width <= ids.size(); i += width) {
    const Slot slot = mesh.FindSimplexSlot(std::span(ids).subspan(i, width));
    if (slot == kNoSlot) continue;
    rows.push_back(slot);
    for (std::size_t k = 0; k < width; ++k) {
      const Slot other = mesh.neighbours()[At(slot) * width + k];
      if (other != kNoSlot) rows.push_back(other);
    }
  }
}

// The rows that a diff changes, from the mesh before it and the mesh after it.
class ChangedRows {
 public:
  ChangedRows(const SlotMesh& before, const MeshDiff& diff, bool extends, bool has_neighbours)
      : diff_(diff), has_neighbours_(has_neighbours) {
    for (const VertexId id : diff.removed_vertices) {
      const Slot slot = before.FindSlot(id);
      if (slot == kNoSlot) continue;
      vertices.push_back(slot);
      slot_of_.emplace_back(id, slot);
    }
    std::sort(slot_of_.begin(), slot_of_.end());
    // What an earlier diff of the patch has changed may come or go again.
    if (extends) AppendCells(before.patch(), cells);
    if (has_neighbours_) AppendWithNeighbours(before, diff.removed_simplices, neighbours);
  }

  void Finish(const SlotMesh& after) {
    for (const VertexId id : diff_.added_vertices.ids) {
      const Slot slot = after.FindSlot(id);
      if (slot == kNoSlot) continue;
      vertices.push_back(slot);
      const auto at = std::lower_bound(slot_of_.begin(), slot_of_.end(), std::pair(id, kNoSlot));
      if (at != slot_of_.end() && at->first == id && at->second != slot) replaces_ids = true;
    }
    AppendCells(after.patch(), cells);
    if (has_neighbours_) AppendWithNeighbours(after, diff_.added_simplices, neighbours);
  }

  std::vector<Slot> vertices, cells, neighbours;
  // Does an id stand for another vertex now? Then rows changed that the diff does not name.
  bool replaces_ids = false;

 private:
  const MeshDiff& diff_;
  const bool has_neighbours_;
  std::vector<std::pair<VertexId, Slot>> slot_of_;
};

}  // namespace

// Holds the lock of edits, unless this thread has it already: then the call came out of an edit.
class ABSL_SCOPED_LOCKABLE SharedMesh::Editing {
 public:
  explicit Editing(SharedMesh& mesh)
      ABSL_EXCLUSIVE_LOCK_FUNCTION(mesh.edit_mutex_) ABSL_NO_THREAD_SAFETY_ANALYSIS
      : mesh_(mesh),
        is_nested_(mesh.editor_.load() == std::this_thread::get_id()) {
    if (is_nested_) return;
    mesh_.edit_mutex_.Lock();
    mesh_.editor_.store(std::this_thread::get_id());
  }
  ~Editing() ABSL_UNLOCK_FUNCTION() ABSL_NO_THREAD_SAFETY_ANALYSIS {
    if (is_nested_) return;
    mesh_.editor_.store(std::thread::id());
    mesh_.edit_mutex_.Unlock();
  }
  Editing(const Editing&) = delete;
  Editing& operator=(const Editing&) = delete;

  absl::Status status() const ABSL_NO_THREAD_SAFETY_ANALYSIS {
    if (mesh_.mesher_ == nullptr) {
      return absl::FailedPreconditionError("a replica of a server's mesh has no mesher here");
    }
    if (mesh_.is_lost_) {
      return absl::DataLossError("memory ran out in an edit of this mesh: open a new one");
    }
    if (!is_nested_) return absl::OkStatus();
    return absl::FailedPreconditionError(
        "this was called from the progress callback of an edit of the same mesh, which is between "
        "two revisions: call it when the edit has returned");
  }

 private:
  SharedMesh& mesh_;
  const bool is_nested_;
};

absl::StatusOr<std::unique_ptr<SharedMesh>> SharedMesh::Create(const MeshOptions& options) {
  auto mesher = DynamicMesh::Create(options);
  if (!mesher.ok()) return mesher.status();
  auto replica = SlotMesh::FromMesh((*mesher)->Snapshot());
  if (!replica.ok()) return replica.status();
  return std::unique_ptr<SharedMesh>(new SharedMesh(*std::move(mesher), *std::move(replica)));
}

absl::StatusOr<std::unique_ptr<SharedMesh>> SharedMesh::FromSnapshot(const Mesh& snapshot) {
  auto replica = SlotMesh::FromMesh(snapshot);
  if (!replica.ok()) return replica.status();
  return std::unique_ptr<SharedMesh>(new SharedMesh(nullptr, *std::move(replica)));
}

SharedMesh::SharedMesh(std::unique_ptr<DynamicMesh> mesher, SlotMesh replica)
    : dimension_(replica.dimension()),
      options_(mesher == nullptr ? MeshOptions() : mesher->options()),
      mesher_(std::move(mesher)),
      replica_(std::move(replica)) {
  NoteNumbers();
}

void SharedMesh::NoteNumbers() {
  const MutexLock lock(numbers_mutex_);
  numbers_ = {replica_.revision(),      replica_.hash(),       replica_.vertex_count(),
              replica_.simplex_count(), replica_.ids().size(), replica_.regions().size()};
}

MeshNumbers SharedMesh::numbers() const {
  const MutexLock lock(numbers_mutex_);
  return numbers_;
}

absl::StatusOr<MeshDiff> SharedMesh::Edit(const EditBatch& batch, ApplyOptions options) {
  const Editing editing(*this);
  if (auto status = editing.status(); !status.ok()) return status;
  // As the last step of the edit: if the replica cannot follow, the edit is undone.
  options.commit = [this](const MeshDiff& diff) {
    if (diff.from_revision == diff.to_revision) return absl::OkStatus();
    const MutexLock lock(replica_mutex_);
    return ApplyLocked(diff, false);
  };
  try {
    return mesher_->Apply(batch, options);
  } catch (const std::bad_alloc&) {
    is_lost_ = true;
    return absl::ResourceExhaustedError(
        "memory ran out in the middle of the edit: this mesh can be read, and takes no more edits; "
        "open a new one");
  }
}

absl::Status SharedMesh::Validate(const EditBatch& batch) {
  const Editing editing(*this);
  if (auto status = editing.status(); !status.ok()) return status;
  return mesher_->Validate(batch);
}

absl::StatusOr<std::vector<Feature>> SharedMesh::Features() {
  const Editing editing(*this);
  if (auto status = editing.status(); !status.ok()) return status;
  return mesher_->Features();
}

absl::StatusOr<std::vector<Slot>> SharedMesh::Locate(std::span<const double> points) {
  const Editing editing(*this);
  if (auto status = editing.status(); !status.ok()) return status;
  const SimplexColumn ids = mesher_->Locate(points);
  const auto width = static_cast<std::size_t>(dimension_ + 1);
  std::vector<Slot> slots;
  slots.reserve(ids.size() / width);
  const MutexLock lock(replica_mutex_);
  for (std::size_t i = 0; i + width <= ids.size(); i += width) {
    slots.push_back(replica_.FindSimplexSlot(std::span(ids).subspan(i, width)));
  }
  return slots;
}

absl::StatusOr<AuditReport> SharedMesh::Audit() {
  const Editing editing(*this);
  if (auto status = editing.status(); !status.ok()) return status;
  return mesher_->Audit();
}

absl::Status SharedMesh::Apply(const MeshDiff& diff, bool extends) {
  const MutexLock lock(replica_mutex_);
  return ApplyLocked(diff, extends);
}

absl::Status SharedMesh::ApplyLocked(const MeshDiff& diff, bool extends) {
  const bool has_vertices =
      points_.in_use() || ids_.in_use() || containing_dimensions_.in_use() || owners_.in_use();
  const bool has_cells = cells_.in_use() || regions_.in_use();
  const bool has_subsegments = subsegments_.in_use() || subsegment_owners_.in_use();
  const bool has_subfacets = subfacets_.in_use() || subfacet_owners_.in_use();
  const auto apply = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(replica_mutex_) {
    return extends ? replica_.Extend(diff) : replica_.Apply(diff);
  };
  absl::Status status;
  if (has_vertices || has_cells || neighbours_.in_use() || has_subsegments || has_subfacets) {
    ChangedRows rows(replica_, diff, extends, neighbours_.in_use());
    if (status = apply(); !status.ok()) return status;
    rows.Finish(replica_);
    const std::size_t cells = replica_.regions().size();
    if (has_vertices) vertex_log_.Add(std::move(rows.vertices), MostRows(replica_.ids().size()));
    if (has_cells) cell_log_.Add(std::move(rows.cells), MostRows(cells));
    if (neighbours_.in_use()) neighbour_log_.Add(std::move(rows.neighbours), MostRows(cells));
    const auto changes = [&](const auto& removed, const auto& added) {
      return rows.replaces_ids || removed.size() + added.size() != 0;
    };
    if (has_subsegments && changes(diff.removed_subsegments, diff.added_subsegments)) {
      subsegment_log_.AddUnknown();
    }
    if (has_subfacets && changes(diff.removed_subfacets, diff.added_subfacets)) {
      subfacet_log_.AddUnknown();
    }
    if (rows.replaces_ids) {
      cell_log_.AddUnknown(), neighbour_log_.AddUnknown();
    }
    points_.DropOld(vertex_log_), ids_.DropOld(vertex_log_), owners_.DropOld(vertex_log_);
    containing_dimensions_.DropOld(vertex_log_);
    cells_.DropOld(cell_log_), regions_.DropOld(cell_log_), neighbours_.DropOld(neighbour_log_);
    subsegments_.DropOld(subsegment_log_), subsegment_owners_.DropOld(subsegment_log_);
    subfacets_.DropOld(subfacet_log_), subfacet_owners_.DropOld(subfacet_log_);
  } else if (status = apply(); !status.ok()) {
    return status;
  }
  NoteNumbers();
  return absl::OkStatus();
}

PatchColumns SharedMesh::TakePatch() const {
  const MutexLock lock(replica_mutex_);
  PatchColumns result;
  result.patch = replica_.patch();
  const auto width = static_cast<std::size_t>(dimension_ + 1);
  const std::vector<Slot>& added = result.patch.added_simplices;
  std::vector<Slot> sorted = added;
  std::sort(sorted.begin(), sorted.end());
  result.added_corners.reserve(added.size() * width);
  for (const Slot slot : added) {
    const Slot* const row = replica_.cells().data() + At(slot) * width;
    result.added_corners.insert(result.added_corners.end(), row, row + width);
    for (std::size_t k = 0; k < width; ++k) {
      const Slot other = replica_.neighbours()[At(slot) * width + k];
      if (other != kNoSlot && std::binary_search(sorted.begin(), sorted.end(), other)) continue;
      result.boundary_faces.insert(result.boundary_faces.end(),
                                   {slot, static_cast<Slot>(k), other});
    }
  }
  return result;
}

CompactColumns SharedMesh::TakeCompact() const {
  const MutexLock lock(replica_mutex_);
  CompactColumns result;
  CompactNumbering& numbering = result.numbering;
  numbering = replica_.Compact();
  const auto d = static_cast<std::size_t>(dimension_), width = d + 1;
  result.points.reserve(numbering.vertex_slots.size() * d);
  for (const Slot slot : numbering.vertex_slots) {
    const double* const position = replica_.points().data() + At(slot) * d;
    result.points.insert(result.points.end(), position, position + d);
  }
  result.cells.reserve(numbering.simplex_slots.size() * width);
  result.regions.reserve(numbering.simplex_slots.size());
  for (const Slot slot : numbering.simplex_slots) {
    const Slot* const row = replica_.cells().data() + At(slot) * width;
    for (std::size_t k = 0; k < width; ++k) {
      result.cells.push_back(numbering.vertex_numbers[At(row[k])]);
    }
    result.regions.push_back(replica_.regions()[At(slot)]);
  }
  return result;
}

HeldColumn<double> SharedMesh::points() {
  return points_.Take(replica_.points(), static_cast<std::size_t>(dimension_), vertex_log_);
}
HeldColumn<VertexId> SharedMesh::ids() { return ids_.Take(replica_.ids(), 1, vertex_log_); }
HeldColumn<std::uint8_t> SharedMesh::containing_dimensions() {
  return containing_dimensions_.Take(replica_.containing_dimensions(), 1, vertex_log_);
}
HeldColumn<FeatureId> SharedMesh::owners() {
  return owners_.Take(replica_.owners(), 1, vertex_log_);
}
HeldColumn<Slot> SharedMesh::cells() {
  return cells_.Take(replica_.cells(), static_cast<std::size_t>(dimension_ + 1), cell_log_);
}
HeldColumn<Slot> SharedMesh::neighbours() {
  return neighbours_.Take(replica_.neighbours(), static_cast<std::size_t>(dimension_ + 1),
                          neighbour_log_);
}
HeldColumn<RegionId> SharedMesh::regions() {
  return regions_.Take(replica_.regions(), 1, cell_log_);
}
HeldColumn<Slot> SharedMesh::subsegments() {
  return subsegments_.Take(replica_.subsegments(), 2, subsegment_log_);
}
HeldColumn<FeatureId> SharedMesh::subsegment_owners() {
  return subsegment_owners_.Take(replica_.subsegment_owners(), 1, subsegment_log_);
}
HeldColumn<Slot> SharedMesh::subfacets() {
  return subfacets_.Take(replica_.subfacets(), 3, subfacet_log_);
}
HeldColumn<FeatureId> SharedMesh::subfacet_owners() {
  return subfacet_owners_.Take(replica_.subfacet_owners(), 1, subfacet_log_);
}

}  // namespace dynmesh::python
