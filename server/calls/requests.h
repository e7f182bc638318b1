// Converts requests to the server's own types, with all checks that do not need the mesh. Does not
// depend on gRPC, so that wire input can be tested without it. Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_REQUESTS_H_
#define DYNMESH_SERVER_CALLS_REQUESTS_H_

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/mesh_data/region_filter.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "server/calls/admission.h"
#include "server/meshes/mesh_host.h"
#include "server/meshes/mesh_registry.h"
#include "server/meshes/watch_hub.h"

namespace dynmesh::server {

// A batch for `host` that came in one message, and its share of the limits.
struct EditRequest {
  MeshRegistry::HostPtr host;
  SharedLimit::Place place;
  EditJob job;  // without its callbacks
};
absl::StatusOr<EditRequest> TakeEditRequest(ServiceContext& context, const Pass& pass,
                                            MeshRegistry::HostPtr host,
                                            const v1::AddFeaturesRequest& request);
absl::StatusOr<EditRequest> TakeEditRequest(ServiceContext& context, const Pass& pass,
                                            MeshRegistry::HostPtr host,
                                            const v1::RemoveFeaturesRequest& request);
absl::StatusOr<EditRequest> TakeEditRequest(ServiceContext& context, const Pass& pass,
                                            MeshRegistry::HostPtr host,
                                            const v1::ApplyEditsRequest& request);
// The batch depends on the mesh's history: no edits yet, and nothing reserved.
absl::StatusOr<EditRequest> TakeEditRequest(ServiceContext& context, const Pass& pass,
                                            MeshRegistry::HostPtr host,
                                            const v1::RevertToRequest& request);

// A batch of an edit stream that is being received. An error goes to job.refused, to be answered in
// the batch's turn; its edits are dropped then.
struct PartialBatch {
  explicit PartialBatch(const v1::EditBatch& first);
  void Add(ServiceContext& context, const Pass& pass, const v1::EditBatch& part, int dimension);

  EditJob job;
  bool omit_columns = false;
  EditShares held;
};

absl::StatusOr<WatchHub::Start> DecodeStart(const v1::WatchRequest& request);
absl::StatusOr<mesh_data::RegionChoice> DecodeRegions(
    const google::protobuf::RepeatedField<std::uint64_t>& regions);

// The box of a new mesh: INVALID_ARGUMENT if it is a single point, as when its corners were left
// out.
absl::Status CheckBoxOfNew(const MeshOptions& options);

absl::Status CheckLocate(const v1::LocatePointsRequest& request, int dimension);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_REQUESTS_H_
