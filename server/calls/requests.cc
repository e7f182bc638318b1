#include "server/calls/requests.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::server {
namespace {

constexpr int kMaxLocatePoints = 30'000;
constexpr int kMaxRegions = 10'000;  // kept as long as the call
constexpr std::size_t kMostOfABadRequestId = 128;

absl::Status Decode(const v1::AddFeaturesRequest& r, int dimension, EditBatch* out) {
  return codec::DecodeAdds(r.features(), dimension, out);
}
absl::Status Decode(const v1::RemoveFeaturesRequest& r, int, EditBatch* out) {
  for (const FeatureId id : r.ids()) out->push_back(Edit::Remove(id));
  return absl::OkStatus();
}
absl::Status Decode(const v1::ApplyEditsRequest& r, int dimension, EditBatch* out) {
  return codec::DecodeEdits(r.edits(), dimension, out);
}

std::size_t Weight(const v1::AddFeaturesRequest& r) { return codec::Weight(r.features()); }
std::size_t Weight(const v1::RemoveFeaturesRequest& r) {
  return static_cast<std::size_t>(r.ids_size());
}
std::size_t Weight(const v1::ApplyEditsRequest& r) { return codec::Weight(r.edits()); }

// Fields common to all messages that make a batch.
template <typename Request>
void TakeParams(const Request& request, EditJob& job) {
  job.request_id = request.request_id();
  if (request.has_expected_revision()) job.expected_revision = request.expected_revision();
}

template <typename Request>
absl::StatusOr<EditRequest> Begin(MeshRegistry::HostPtr host, const Request& request) {
  EditRequest taken;
  if (absl::Status s = CheckRequestId(request.request_id()); !s.ok()) return s;
  taken.host = std::move(host);
  TakeParams(request, taken.job);
  return taken;
}

template <typename Request>
absl::StatusOr<EditRequest> Take(ServiceContext& context, const Pass& pass,
                                 MeshRegistry::HostPtr host, const Request& request) {
  absl::StatusOr<EditRequest> taken = Begin(std::move(host), request);
  if (!taken.ok()) return taken;
  absl::StatusOr<SharedLimit::Place> place = TakeEdits(context, pass, 0, Weight(request));
  if (!place.ok()) return place.status();
  taken->place = *std::move(place);
  const int dimension = taken->host->mesh_options().dimension;
  if (absl::Status s = Decode(request, dimension, &taken->job.edits); !s.ok()) return s;
  taken->job.validate_only = request.validate_only();
  return taken;
}

}  // namespace

absl::StatusOr<EditRequest> TakeEditRequest(ServiceContext& context, const Pass& pass,
                                            MeshRegistry::HostPtr host,
                                            const v1::AddFeaturesRequest& request) {
  return Take(context, pass, std::move(host), request);
}
absl::StatusOr<EditRequest> TakeEditRequest(ServiceContext& context, const Pass& pass,
                                            MeshRegistry::HostPtr host,
                                            const v1::RemoveFeaturesRequest& request) {
  return Take(context, pass, std::move(host), request);
}
absl::StatusOr<EditRequest> TakeEditRequest(ServiceContext& context, const Pass& pass,
                                            MeshRegistry::HostPtr host,
                                            const v1::ApplyEditsRequest& request) {
  return Take(context, pass, std::move(host), request);
}

absl::StatusOr<EditRequest> TakeEditRequest(ServiceContext&, const Pass&,
                                            MeshRegistry::HostPtr host,
                                            const v1::RevertToRequest& request) {
  return Begin(std::move(host), request);
}

PartialBatch::PartialBatch(const v1::EditBatch& first) : omit_columns(first.omit_columns()) {
  TakeParams(first, job);
  job.validate_only = first.validate_only();
  job.refused = CheckRequestId(job.request_id);
  if (!job.refused.ok()) job.request_id = job.request_id.substr(0, kMostOfABadRequestId);
}

void PartialBatch::Add(ServiceContext& context, const Pass& pass, const v1::EditBatch& part,
                       int dimension) {
  if (!job.refused.ok()) return;  // the rest of a refused batch is skipped
  job.refused = held.Take(context, pass, codec::Weight(part.edits()));
  if (job.refused.ok()) job.refused = codec::DecodeEdits(part.edits(), dimension, &job.edits);
  if (!job.refused.ok()) {
    EditBatch().swap(job.edits);
    held.Release();
  }
}

absl::StatusOr<WatchHub::Start> DecodeStart(const v1::WatchRequest& request) {
  WatchHub::Start start;
  if (request.has_start_revision() && request.regions_size() > 0) {
    return BadRequest("start_revision",
                      "is not possible with regions: watch without it, from a "
                      "snapshot");
  }
  if (request.has_start_revision()) start.revision = request.start_revision();
  if (!request.start_hash().empty()) {
    const absl::StatusOr<MeshHash> hash = MeshHash::FromHex(request.start_hash());
    if (!hash.ok()) return BadRequest("start_hash", "must be 32 hex digits");
    start.hash = *hash;
  }
  const auto& interval = request.progress_interval();
  if (interval.seconds() < 0 || interval.nanos() < 0) {
    return BadRequest("progress_interval", "must not be negative");
  }
  start.progress_interval = absl::Seconds(interval.seconds()) + absl::Nanoseconds(interval.nanos());
  return start;
}

absl::StatusOr<mesh_data::RegionChoice> DecodeRegions(
    const google::protobuf::RepeatedField<std::uint64_t>& regions) {
  if (regions.size() > kMaxRegions) {
    return BadRequest("regions", absl::StrCat("at most ", kMaxRegions, " in one request"));
  }
  mesh_data::RegionChoice choice;
  choice.in.assign(regions.begin(), regions.end());
  mesh_data::Normalize(choice);
  if (!choice.in.empty() &&
      (choice.in.front() == kNoFeature || choice.in.back() > kLastPolygonId)) {
    return BadRequest("regions", absl::StrCat("must be ids of polygons, 1 to ", kLastPolygonId));
  }
  return choice;
}

absl::Status CheckBoxOfNew(const MeshOptions& options) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(options.dimension); ++i) {
    if (options.box.lo[i] != options.box.hi[i]) return absl::OkStatus();
  }
  codec::ServiceError error;
  error.reason = reason::kBadOption;
  error.field = "options.box";
  return codec::MakeServiceError(
      absl::StatusCode::kInvalidArgument,
      "options.box: both corners are the same place, and features have no room: set lo and hi",
      error);
}

absl::Status CheckLocate(const v1::LocatePointsRequest& request, int dimension) {
  const auto& x = request.coordinates();
  if (x.size() % dimension != 0) {
    return BadRequest("coordinates", absl::StrCat("their number must be a multiple of the mesh's "
                                                  "dimension ",
                                                  dimension));
  }
  if (x.size() / dimension > kMaxLocatePoints) {
    return BadRequest("coordinates",
                      absl::StrCat("at most ", kMaxLocatePoints, " points in one request"));
  }
  const auto bad = std::find_if(x.begin(), x.end(), [](double v) { return !std::isfinite(v); });
  if (bad == x.end()) return absl::OkStatus();
  codec::ServiceError error;
  error.reason = reason::kNotFinite;
  error.field = absl::StrCat("coordinates[", bad - x.begin(), "]");
  return codec::MakeServiceError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat("point ", (bad - x.begin()) / dimension, " has a coordinate that is not finite"),
      error);
}

}  // namespace dynmesh::server
