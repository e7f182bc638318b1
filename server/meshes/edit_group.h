// Batches that a mesh's writer has applied and that are written to the journal together, in order.
// They are answered only after that. The group also holds answers that depend on these changes,
// such as refusals: if the write fails, they fail, too. Thread-compatible: belongs to the mesh's
// strand.
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
  bool judged = false;          // the outcome depends on the mesh's state
  bool unwritten = false;       // it succeeded and waits for the journal,
  RequestMemory::Entry answer;  // to be written with this answer
  MeshStats stats;              // of the mesh after it
  std::size_t bytes = 0;        // of edits and diff, as AppendPipeline counts them
};

class EditGroup {
 public:
  bool empty() const { return edits_.empty(); }
  const HeldEdit& front() const { return edits_.front(); }
  std::size_t size() const { return edits_.size(); }
  // Number of revisions that its batches made.
  std::size_t revisions() const { return revisions_; }
  // The unwritten batch with this request_id; null if there is none.
  const HeldEdit* Find(absl::string_view request_id) const;
  // The batches for the journal. Valid until Add or Take.
  std::vector<MeshLog::Batch> Unwritten() const;

  void Add(HeldEdit edit);
  // Removes and returns the answers before the first unwritten batch, in order.
  std::vector<HeldEdit> TakeAnswers();
  // Returns all, in order, and empties the group.
  std::vector<HeldEdit> Take();

 private:
  std::vector<HeldEdit> edits_;
  std::size_t revisions_ = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_EDIT_GROUP_H_
