// Progress on the wire, of loads and builds. Pure.
#ifndef DYNMESH_SERVER_CALLS_PROGRESS_STAGE_H_
#define DYNMESH_SERVER_CALLS_PROGRESS_STAGE_H_

#include <chrono>

#include "dynmesh/v1/mesh_service.pb.h"
#include "server/meshes/batch_progress.h"

namespace dynmesh::server {

inline constexpr std::chrono::milliseconds kBetweenProgress{500};

inline v1::LoadFeaturesResponse::Stage StageOf(BatchProgress::Stage stage) {
  switch (stage) {
    case BatchProgress::Stage::kValidate:
      return v1::LoadFeaturesResponse::VALIDATING;
    case BatchProgress::Stage::kRefine:
      return v1::LoadFeaturesResponse::REFINING;
    case BatchProgress::Stage::kDiff:
      return v1::LoadFeaturesResponse::DIFFING;
    case BatchProgress::Stage::kJournal:
      return v1::LoadFeaturesResponse::JOURNALING;
  }
  return v1::LoadFeaturesResponse::STAGE_UNSPECIFIED;
}

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_PROGRESS_STAGE_H_
