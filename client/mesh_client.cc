#include "dynmesh/client/mesh_client.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "client/channel_internal.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/features_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::client {
namespace {

constexpr int kPageSize = 1000;
constexpr std::size_t kLocatePoints = 30'000;  // per request

absl::StatusOr<MeshInfo> DecodeMesh(const v1::Mesh& proto) {
  MeshInfo info;
  info.id = proto.name().substr(proto.name().find('/') + 1);
  info.damage = proto.damage();
  info.owner = proto.owner();
  info.create_time = absl::FromUnixSeconds(proto.create_time().seconds()) +
                     absl::Nanoseconds(proto.create_time().nanos());
  info.revision = proto.revision();
  if (!proto.has_options()) return info;
  info.read_only = !info.damage.empty();
  auto options = codec::DecodeOptions(proto.options(), std::numeric_limits<std::uint64_t>::max());
  if (!options.ok()) return options.status();
  info.options = *options;
  auto hash = MeshHash::FromHex(proto.hash());
  if (!hash.ok()) return absl::DataLossError("the server sent a hash that is none");
  info.hash = *hash;
  return info;
}

absl::StatusOr<MeshStatus> DecodeStats(const v1::MeshStats& proto) {
  MeshStatus status;
  status.stats.revision = proto.revision();
  status.stats.features = proto.features();
  status.stats.vertices = proto.vertices();
  status.stats.simplices = proto.simplices();
  status.stats.subsegments = proto.subsegments();
  status.stats.subfacets = proto.subfacets();
  status.dimension = proto.dimension() == 3 ? 3 : 2;
  status.stats.operations = proto.operations();
  status.stats.trace_bytes = proto.trace_bytes();
  status.stats.mesh_bytes = proto.mesh_bytes();
  status.oldest_revision = proto.oldest_revision();
  status.watchers = proto.watchers();
  status.waiting_edits = proto.waiting_edits();
  auto hash = MeshHash::FromHex(proto.hash());
  if (!hash.ok()) return absl::DataLossError("the server sent a hash that is none");
  status.hash = *hash;
  return status;
}

template <typename Request>
void EncodeParams(const std::string& mesh, const EditParams& params, Request* request) {
  request->set_mesh(FullName(mesh));
  request->set_request_id(params.request_id);
  if (params.expected_revision.has_value()) {
    request->set_expected_revision(*params.expected_revision);
  }
  request->set_validate_only(params.validate_only);
  request->set_omit_columns(params.omit_columns);
}

// Joins a chunked value. Reads to the end even after an error.
template <typename Whole, typename Chunk, typename Assembler>
absl::StatusOr<Whole> ReadWhole(grpc::ClientReader<Chunk>& reader, Assembler assembler,
                                const char* missing) {
  std::optional<Whole> whole;
  absl::Status broken;
  Chunk chunk;
  while (reader.Read(&chunk)) {
    auto added = assembler.Add(chunk);
    broken.Update(added.status());
    if (added.ok() && added->has_value()) whole = **std::move(added);
  }
  const grpc::Status status = reader.Finish();
  if (!status.ok()) return codec::FromGrpcStatus(status);
  if (!broken.ok()) return broken;
  if (!whole.has_value()) return absl::DataLossError(missing);
  return *std::move(whole);
}

absl::StatusOr<EditResult> ReadResult(grpc::ClientReader<v1::MeshDiff>& reader) {
  return ReadWhole<EditResult>(reader, ResultAssembler(), "the server sent no whole diff");
}

std::shared_ptr<grpc::ChannelCredentials> Credentials(const ClientOptions& options) {
  if (!options.tls()) return grpc::InsecureChannelCredentials();
  return grpc::SslCredentials({options.tls_ca, options.tls_key, options.tls_certificate});
}

}  // namespace

struct MeshClient::Impl {
  std::shared_ptr<Stub> stub;
  absl::Duration timeout;

  // A unary call: `method` of the stub. `mesh`: its full name, or empty.
  template <typename Method, typename Request, typename Response>
  absl::Status Call(const std::string& mesh, bool repeatable, Method method, const Request& request,
                    Response* response) const {
    return stub->Follow(
        mesh, repeatable, timeout, [&](Stub::Service& service, grpc::ClientContext& context) {
          return codec::FromGrpcStatus((service.*method)(&context, request, response));
        });
  }

  // A call that streams the result of a batch.
  template <typename Method, typename Request>
  absl::StatusOr<EditResult> Edit(Method method, const Request& request, bool repeatable) const {
    absl::StatusOr<EditResult> result =
        stub->Follow(request.mesh(), repeatable, timeout,
                     [&](Stub::Service& service, grpc::ClientContext& context) {
                       return ReadResult(*(service.*method)(&context, request));
                     });
    if (result.ok()) stub->Saw(request.mesh(), result->diff.to_revision);
    return result;
  }

  // A read, whose answer `run(service, context)` returns; it may be a follower's.
  template <typename Request, typename Run>
  auto Read(Request* request, const Run& run) const {
    const std::string key = stub->ReadKey(request->mesh());
    stub->Forget(key);
    stub->AskFollowers(request);
    return stub->Follow(key, /*repeatable=*/true, timeout, run);
  }

  absl::StatusOr<EditResult> ApplyInParts(const std::string& mesh, const EditBatch& edits,
                                          const EditParams& params) const {
    auto session = StartEditSession(stub, mesh, /*stop_on_error=*/true, timeout);
    absl::Status sent = session->Send(edits, params);
    if (sent.ok()) sent = session->DoneSending();
    std::optional<EditSession::Answer> answer = session->Receive();
    while (session->Receive().has_value()) {
    }
    const absl::Status finish = session->Finish();
    if (answer.has_value()) return std::move(answer->result);
    if (!finish.ok()) return finish;
    return sent.ok() ? absl::DataLossError("the server sent no answer") : sent;
  }
};

MeshClient::MeshClient(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MeshClient::~MeshClient() = default;

std::unique_ptr<MeshClient> MeshClient::Connect(const std::string& address,
                                                const ClientOptions& options) {
  grpc::ChannelArguments arguments;
  if (options.own_connection) arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // Another server may take the place of one whose machine or network is gone: a call notices it
  // after the two times together, if WaitingCalls does not.
  const bool is_one = address.find(',') == std::string::npos;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, is_one ? 60'000 : 5'000);
  if (!is_one) {
    arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
    arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 5'000);  // limits an attempt to connect
  }
  // Otherwise a watch without events would not be looked after any more after two pings.
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // The connector decides when the next attempt is due.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 5'000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 5'000);
  auto impl = std::make_unique<Impl>();
  impl->stub = std::make_shared<Stub>(address, Credentials(options), arguments, options.token,
                                      options.from_followers);
  impl->timeout = options.timeout;
  return std::unique_ptr<MeshClient>(new MeshClient(std::move(impl)));
}

absl::StatusOr<MeshInfo> MeshClient::CreateMesh(const std::string& id, const MeshOptions& options,
                                                const std::string& request_id) {
  v1::CreateMeshRequest request;
  request.set_mesh_id(id);
  request.set_request_id(request_id);
  EncodeNewOptions(options, request.mutable_options());
  v1::Mesh response;
  // A retry has to get to the server of the first. Any server can make it.
  const std::string name = id.empty() ? "request " + request_id : "creation of " + FullName(id);
  if (auto s =
          impl_->Call(name, !request_id.empty(), &Stub::Service::CreateMesh, request, &response);
      !s.ok())
    return s;
  return DecodeMesh(response);
}

absl::StatusOr<MeshInfo> MeshClient::GetMesh(const std::string& mesh) {
  v1::GetMeshRequest request;
  request.set_mesh(FullName(mesh));
  v1::Mesh response;
  if (auto s = impl_->Call(request.mesh(), true, &Stub::Service::GetMesh, request, &response);
      !s.ok())
    return s;
  return DecodeMesh(response);
}

absl::StatusOr<std::vector<MeshInfo>> MeshClient::ListMeshes() {
  std::vector<MeshInfo> meshes;
  v1::ListMeshesRequest request;
  request.set_page_size(kPageSize);
  do {
    v1::ListMeshesResponse response;
    if (auto s = impl_->Call("", true, &Stub::Service::ListMeshes, request, &response); !s.ok())
      return s;
    for (const v1::Mesh& proto : response.meshes()) {
      auto mesh = DecodeMesh(proto);
      if (!mesh.ok()) return mesh.status();
      meshes.push_back(*std::move(mesh));
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return meshes;
}

absl::Status MeshClient::DeleteMesh(const std::string& mesh) {
  v1::DeleteMeshRequest request;
  request.set_mesh(FullName(mesh));
  v1::DeleteMeshResponse response;
  return impl_->Call(request.mesh(), false, &Stub::Service::DeleteMesh, request, &response);
}

absl::StatusOr<EditResult> MeshClient::Apply(const std::string& mesh, const EditBatch& edits,
                                             const EditParams& params) {
  if (absl::Status s = CheckDimension(params.dimension); !s.ok()) return s;
  if (PartEnd<Edit>(edits, 0) < edits.size()) return impl_->ApplyInParts(mesh, edits, params);
  v1::ApplyEditsRequest request;
  EncodeParams(mesh, params, &request);
  for (const Edit& edit : edits) codec::EncodeEdit(edit, params.dimension, request.add_edits());
  return impl_->Edit(&Stub::Service::ApplyEdits, request,
                     !params.request_id.empty() || params.validate_only);
}

absl::StatusOr<EditResult> MeshClient::AddFeatures(const std::string& mesh,
                                                   std::span<const Feature> features,
                                                   const EditParams& params) {
  if (absl::Status s = CheckDimension(params.dimension); !s.ok()) return s;
  if (PartEnd(features, 0) < features.size()) {
    EditBatch edits;
    for (const Feature& f : features) edits.push_back(Edit::Add(f));
    return impl_->ApplyInParts(mesh, edits, params);
  }
  v1::AddFeaturesRequest request;
  EncodeParams(mesh, params, &request);
  for (const Feature& f : features)
    codec::EncodeFeature(f, params.dimension, request.add_features());
  return impl_->Edit(&Stub::Service::AddFeatures, request,
                     !params.request_id.empty() || params.validate_only);
}

absl::StatusOr<EditResult> MeshClient::RemoveFeatures(const std::string& mesh,
                                                      std::span<const FeatureId> ids,
                                                      const EditParams& params) {
  if (ids.size() > kIdsPerMessage) {
    EditBatch edits;
    for (const FeatureId id : ids) edits.push_back(Edit::Remove(id));
    return impl_->ApplyInParts(mesh, edits, params);
  }
  v1::RemoveFeaturesRequest request;
  EncodeParams(mesh, params, &request);
  request.mutable_ids()->Add(ids.begin(), ids.end());
  return impl_->Edit(&Stub::Service::RemoveFeatures, request,
                     !params.request_id.empty() || params.validate_only);
}

absl::StatusOr<LoadResult> MeshClient::Load(const std::string& mesh, const FeatureSource& source,
                                            const LoadParams& params) {
  return RunLoad(*impl_->stub, mesh, source, params, impl_->timeout);
}

absl::StatusOr<LoadResult> MeshClient::Load(const std::string& mesh,
                                            std::span<const Feature> features,
                                            const LoadParams& params) {
  return Load(
      mesh, [&] { return std::exchange(features, {}); }, params);
}

absl::StatusOr<codec::FeaturesAt> MeshClient::GetFeatures(const std::string& mesh,
                                                          std::optional<std::uint64_t> revision) {
  const absl::StatusOr<MeshInfo> info = GetMesh(mesh);
  if (!info.ok()) return info.status();
  v1::GetFeaturesRequest request;
  request.set_mesh(FullName(mesh));
  if (revision.has_value()) request.set_revision(*revision);
  auto found = impl_->Read(&request, [&](Stub::Service& service, grpc::ClientContext& context) {
    return ReadWhole<codec::FeaturesAt>(*service.GetFeatures(&context, request),
                                        codec::FeaturesAssembler(info->options.dimension),
                                        "the server sent not all features");
  });
  if (found.ok()) impl_->stub->Saw(request.mesh(), found->revision);
  return found;
}

absl::StatusOr<EditResult> MeshClient::RevertTo(const std::string& mesh, std::uint64_t revision,
                                                const EditParams& params) {
  v1::RevertToRequest request;
  request.set_mesh(FullName(mesh));
  request.set_revision(revision);
  request.set_request_id(params.request_id);
  if (params.expected_revision.has_value()) {
    request.set_expected_revision(*params.expected_revision);
  }
  request.set_omit_columns(params.omit_columns);
  return impl_->Edit(&Stub::Service::RevertTo, request, !params.request_id.empty());
}

void MeshClient::PauseBeforeRetry(absl::Duration limit) { impl_->stub->connector().Pause(limit); }

std::uint64_t MeshClient::servers_returned() const { return impl_->stub->connector().reached(); }

std::unique_ptr<EditSession> MeshClient::OpenEdits(const std::string& mesh, bool stop_on_error) {
  return StartEditSession(impl_->stub, mesh, stop_on_error, absl::InfiniteDuration());
}

std::unique_ptr<WatchSession> MeshClient::Watch(const std::string& mesh,
                                                const WatchOptions& options,
                                                WatchListener* listener) {
  return StartWatchSession(impl_->stub, mesh, options, listener);
}

std::unique_ptr<DiffStream> MeshClient::StreamDiffs(const std::string& mesh,
                                                    const DiffStreamOptions& options) {
  return StartDiffStream(impl_->stub, mesh, options);
}

absl::StatusOr<Mesh> MeshClient::GetSnapshot(const std::string& mesh,
                                             std::span<const FeatureId> regions) {
  v1::GetSnapshotRequest request;
  request.set_mesh(FullName(mesh));
  request.mutable_regions()->Add(regions.begin(), regions.end());
  absl::StatusOr<Mesh> found =
      impl_->Read(&request, [&](Stub::Service& service, grpc::ClientContext& context) {
        return ReadWhole<Mesh>(*service.GetSnapshot(&context, request), codec::SnapshotAssembler(),
                               "the server sent no whole snapshot");
      });
  if (found.ok()) impl_->stub->Saw(request.mesh(), found->revision);
  // The rows must have the hash that came with them.
  if (found.ok() && ComputeHash(*found) != found->hash) {
    return absl::DataLossError("the snapshot's rows do not have its hash");
  }
  return found;
}

absl::StatusOr<Mesh> MeshClient::BuildMesh(std::span<const Feature> features,
                                           const MeshOptions& options, const BuildParams& params) {
  return RunBuild(*impl_->stub, features, options, params, impl_->timeout);
}

absl::StatusOr<ServerStatus> MeshClient::GetStats(const std::string& mesh) {
  v1::GetStatsRequest request;
  if (!mesh.empty()) request.set_mesh(FullName(mesh));
  v1::GetStatsResponse response;
  if (auto s = impl_->Call(request.mesh(), true, &Stub::Service::GetStats, request, &response);
      !s.ok())
    return s;
  ServerStatus status;
  status.version = response.server_version();
  status.uptime =
      absl::Seconds(response.uptime().seconds()) + absl::Nanoseconds(response.uptime().nanos());
  status.meshes = response.meshes();
  status.watchers = response.watchers();
  if (response.has_mesh()) {
    auto stats = DecodeStats(response.mesh());
    if (!stats.ok()) return stats.status();
    status.mesh = *std::move(stats);
  }
  return status;
}

absl::StatusOr<Located> MeshClient::Locate(const std::string& mesh, int dimension,
                                           std::span<const double> points) {
  if (absl::Status s = CheckDimension(dimension); !s.ok()) return s;
  Located located;
  const std::size_t step = kLocatePoints * static_cast<std::size_t>(dimension);
  std::size_t begin = 0;
  do {
    const auto part = points.subspan(begin, std::min(step, points.size() - begin));
    v1::LocatePointsRequest request;
    request.set_mesh(FullName(mesh));
    request.mutable_coordinates()->Add(part.begin(), part.end());
    v1::LocatePointsResponse response;
    const absl::Status status =
        impl_->Read(&request, [&](Stub::Service& service, grpc::ClientContext& context) {
          return codec::FromGrpcStatus(service.LocatePoints(&context, request, &response));
        });
    if (!status.ok()) return status;
    impl_->stub->Saw(request.mesh(), response.revision());
    if (begin > 0 && response.revision() != located.revision) {
      return absl::AbortedError("the mesh changed between two parts of the question: ask again");
    }
    located.revision = response.revision();
    const auto& ids = response.simplices().vertex_ids();
    located.simplices.insert(located.simplices.end(), ids.begin(), ids.end());
    located.leaf_sides.insert(located.leaf_sides.end(), response.leaf_sides().begin(),
                              response.leaf_sides().end());
    begin += step;
  } while (begin < points.size());
  return located;
}

}  // namespace dynmesh::client
