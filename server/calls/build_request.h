// A build while it is received: options, then features in parts, with their share of the limits.
// Does not depend on gRPC. Not thread-safe.
#ifndef DYNMESH_SERVER_CALLS_BUILD_REQUEST_H_
#define DYNMESH_SERVER_CALLS_BUILD_REQUEST_H_

#include <cstddef>

#include "absl/status/status.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"
#include "server/calls/load_parts.h"
#include "server/meshes/build_pool.h"

namespace dynmesh::server {

class BuildRequest {
 public:
  // Adds the stream's next message. After an error the build is to be refused.
  absl::Status Add(ServiceContext& context, const Pass& pass, const v1::BuildMeshRequest& message);

  bool has_begun() const { return has_begun_; }
  std::size_t features() const { return edits_.size(); }

  // The job, without what its call adds. Once, after the last message.
  BuildJob TakeJob();
  // Gives back the share of the limits. After TakeJob.
  void Release() { held_.Release(); }

  // As LoadParts::Locate.
  absl::Status Locate(const absl::Status& status) const { return parts_.Locate(status); }

 private:
  absl::Status Begin(ServiceContext& context, const v1::BuildMeshRequest& first);
  absl::Status Reserve(ServiceContext& context, const Pass& pass,
                       const v1::BuildMeshRequest& message);

  bool has_begun_ = false;
  BuildJob job_;
  EditBatch edits_;
  std::size_t weight_ = 0;
  EditShares held_;
  LoadParts parts_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_BUILD_REQUEST_H_
