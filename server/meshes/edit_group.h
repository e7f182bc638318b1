// Batches that a mesh's writer has been through and that wait to be written down together, in its
// order. Until then no client is told of them. What was judged by a mesh that has the changes before
// it stands or falls with these: if they cannot be written down, it is refused as they are.
// Thread-compatible: it belongs to the mesh's strand.
#ifndef DYNMESH_SERVER_MESHES_EDIT_GROUP_H_
#define DYNMESH_SERVER_MESHES_EDIT_GROUP_H_

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/journal/mesh_log.h"
#include "server/meshes/edit_job.h"

namespace dynmesh::server {

struct HeldEdit {
  explicit HeldEdit(std::shared_ptr<EditJob> its) : job(std::move(its)) {}

  std::shared_ptr<EditJob> job;
  absl::StatusOr<EditOutcome> outcome;
  bool judged = false;          // the outcome says something of the mesh
  bool unwritten = false;       // it went well and is to be written down:
  RequestMemory::Entry answer;  // with this
  MeshStats stats;              // of the mesh then
};

class EditGroup {
 public:
  bool empty() const { return edits_.empty(); }
  const HeldEdit& front() const { return edits_.front(); }
  // Revisions that its batches made.
  std::size_t revisions() const { return revisions_; }
  // The batch to be written down that has this request_id; null: none.
  const HeldEdit* Find(absl::string_view request_id) const;
  // What is to be written down. Valid until Add or Take.
  std::vector<MeshLog::Batch> Unwritten() const;

  void Add(HeldEdit edit);
  // All, in order; leaves it empty.
  std::vector<HeldEdit> Take();

 private:
  std::vector<HeldEdit> edits_;
  std::size_t revisions_ = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_EDIT_GROUP_H_
