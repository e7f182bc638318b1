// Progress of the batch that a mesh's writer is applying. Plain data.
#ifndef DYNMESH_SERVER_MESHES_BATCH_PROGRESS_H_
#define DYNMESH_SERVER_MESHES_BATCH_PROGRESS_H_

#include <cstdint>

#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::server {

struct BatchProgress {
  // The stages of ApplyProgress, then the server's own.
  enum class Stage : std::uint8_t { kValidate, kRefine, kDiff, kJournal };

  BatchProgress() = default;
  BatchProgress(const ApplyProgress& p)  // NOLINT(google-explicit-constructor)
      : stage(static_cast<Stage>(p.stage)), done(p.done), total(p.total) {}
  static BatchProgress Journal() {
    BatchProgress progress;
    progress.stage = Stage::kJournal;
    return progress;
  }

  Stage stage = Stage::kValidate;
  std::uint64_t done = 0;
  std::uint64_t total = 0;  // 0: unknown
};
static_assert(static_cast<int>(BatchProgress::Stage::kDiff) ==
              static_cast<int>(ApplyProgress::Stage::kDiff));

// The stage's name in logs and metrics.
inline const char* NameOf(BatchProgress::Stage stage) {
  switch (stage) {
    case BatchProgress::Stage::kValidate:
      return "validate";
    case BatchProgress::Stage::kRefine:
      return "propagate";
    case BatchProgress::Stage::kDiff:
      return "diff";
    case BatchProgress::Stage::kJournal:
      return "journal";
  }
  return "";
}

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_BATCH_PROGRESS_H_
