// Requests of a client. A part of the input is a kind and a message, decoded by the code of the
// server's calls and given to its meshes; or batches in the packing of batches.h, encoded first, so
// that random changes of bytes reach deep code as well. There is no network.
#include <chrono>
#include <condition_variable>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh_data/region_filter.h"
#include "dynmesh/client/mesh_replica.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "server/base/log.h"
#include "server/calls/requests.h"
#include "server/meshes/watch_filter.h"
#include "tests/fuzz/batches.h"
#include "tests/fuzz/quiet.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/fuzz/targets.h"
#include "tests/support/deadline.h"

namespace dynmesh::fuzz {
namespace {

using server::EditJob;
using server::EditOutcome;
using server::MeshHost;
using server::MeshRegistry;
using server::WatchItem;

constexpr std::size_t kMostParts = 16;
constexpr std::size_t kMostPacked = 6;         // batches in one part
constexpr std::size_t kFragmentBytes = 2'000;  // so that there are several
constexpr std::chrono::seconds kLong(10);

server::ServerConfig Config() {
  server::ServerConfig config;
  config.max_meshes = 3;
  config.max_vertices = kMostVerticesInSpace;
  config.max_features = kMostFeatures;
  config.max_batch_edits = 2 * kMostFeatures;
  config.max_pending_edits = 3 * kMostFeatures;
  config.history_revisions = 4;
  config.watch_queue = 2;
  config.remembered_requests = 3;
  return config;
}

// A refusal must name its cause.
std::string CheckRefusal(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kAborted:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kResourceExhausted:
    case absl::StatusCode::kCancelled:
      break;
    default:
      return "not a refusal: " + status.ToString();
  }
  if (status.message().empty()) return "a refusal without a message";
  const grpc::Status wire = codec::ToGrpcStatus(status);
  // What HTTP/2 takes as a header.
  if (wire.error_message().size() + wire.error_details().size() > 8'000) return "a long refusal";
  return codec::FromGrpcStatus(wire).code() == status.code() ? "" : "a refusal changed its code";
}

// Encodes, sends and takes an item of a watch.
absl::Status Send(const WatchItem& item, client::MeshReplica& replica) {
  absl::Status taken;
  v1::WatchEvent event;
  const auto take = [&] {
    v1::WatchEvent received;
    if (!received.ParseFromString(event.SerializeAsString())) return absl::DataLossError("parse");
    return replica.Take(received).status();
  };
  if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&item)) {
    codec::SnapshotFragmenter fragmenter(*mesh, kFragmentBytes);
    while (taken.ok() && fragmenter.Next(event.mutable_snapshot())) taken = take();
  } else if (const auto* diff = std::get_if<std::shared_ptr<const MeshDiff>>(&item)) {
    codec::DiffFragmenter fragmenter(*diff, false, kFragmentBytes);
    while (taken.ok() && fragmenter.Next(event.mutable_diff())) taken = take();
  } else if (const auto* head = std::get_if<server::Head>(&item)) {
    event.mutable_progress()->set_revision(head->revision);
    event.mutable_progress()->set_hash(head->hash.ToHex());
    taken = take();
  } else {
    taken = std::get<absl::Status>(item);
  }
  return taken;
}

// The next item of a watch; none if it is idle.
std::optional<WatchItem> NextItem(server::Subscription& subscription) {
  WatchItem item;
  switch (subscription.Next(&item)) {
    case server::Subscription::Step::kItem:
      return item;
    case server::Subscription::Step::kIdle:
      return std::nullopt;
    case server::Subscription::Step::kWork:
      return subscription.Work();
  }
  return std::nullopt;
}

// A mesh and a watcher of all its revisions.
class Followed {
 public:
  Followed(MeshRegistry::HostPtr host, const DynamicMesh* mesh)
      : host_(std::move(host)), mesh_(mesh) {
    auto subscription = host_->hub()->Subscribe({}, [wakes = wakes_] { wakes->Add(); });
    if (subscription.ok()) subscription_ = *std::move(subscription);
  }

  MeshHost& host() { return *host_; }

  // To the head. `changed`: the watcher was idle, and there is a new revision.
  std::string CatchUp(bool changed) {
    if (changed && !wakes_->Take()) return "a watcher was not woken";
    while (const auto item = NextItem(*subscription_)) {
      if (const absl::Status s = Send(*item, replica_); !s.ok()) return "a watch: " + s.ToString();
    }
    const server::Head head = host_->head();
    if (replica_.revision() == head.revision && replica_.hash() == head.hash) return "";
    return "a watcher that has all has another mesh";
  }

  // No edit is under way.
  std::string CompareWithScratch() const {
    const auto scratch = BuildMesh(mesh_->Features(), mesh_->options());
    if (!scratch.ok()) return "from scratch it is refused: " + scratch.status().ToString();
    if (scratch->hash != mesh_->hash()) return "from scratch it is another mesh";
    return ComputeHash(mesh_->Snapshot()) == mesh_->hash() ? ""
                                                           : "the hash is not that of the rows";
  }

 private:
  class Wakes {
   public:
    void Add() {
      const std::lock_guard lock(mutex_);
      ++count_;
      changed_.notify_all();
    }
    bool Take() {
      std::unique_lock lock(mutex_);
      const bool woken = changed_.wait_for(lock, kLong, [this] { return count_ > 0; });
      count_ -= woken ? 1 : 0;
      return woken;
    }

   private:
    std::mutex mutex_;
    std::condition_variable changed_;
    int count_ = 0;
  };

  const MeshRegistry::HostPtr host_;
  const DynamicMesh* const mesh_;  // the host's
  const std::shared_ptr<Wakes> wakes_ = std::make_shared<Wakes>();
  std::shared_ptr<server::Subscription> subscription_;
  client::MeshReplica replica_;
};

class Service {
 public:
  Service() {
    v1::CreateMeshRequest request;
    request.set_mesh_id("m");
    codec::EncodeOptions(MeshOptions(), request.mutable_options());
    request.mutable_options()->clear_max_vertices();
    Do(request);
  }

  std::string Do(const v1::CreateMeshRequest& request) {
    if (const auto s = server::CheckRequestId(request.request_id()); !s.ok()) {
      return CheckRefusal(s);
    }
    const auto options = codec::DecodeOptions(request.options(), config_.max_vertices);
    if (!options.ok()) return CheckRefusal(options.status());
    const auto host = registry_.Create(request.mesh_id(), *options, request.request_id());
    if (!host.ok()) return CheckRefusal(host.status());
    if (meshes_.count((*host)->id()) != 0) return "";  // a retry
    const auto it = meshes_.emplace((*host)->id(), Followed(*host, made_)).first;
    return it->second.CatchUp(false);
  }

  template <typename Request>
  std::string DoEdits(const Request& request) {
    const auto host = registry_.Find(request.mesh());
    if (!host.ok()) return CheckRefusal(host.status());
    auto taken = server::TakeEditRequest(context_, server::Pass(), *host, request);
    if (!taken.ok()) return CheckRefusal(taken.status());
    return Run(taken->host->id(), std::move(taken->job));
  }

  std::string Do(const v1::EditBatch& message) {
    if (stream_host_ == nullptr) {
      const auto host = registry_.Find(message.mesh());
      if (!host.ok()) return CheckRefusal(host.status());
      stream_host_ = *host;
    }
    if (!partial_.has_value()) partial_.emplace(message);
    partial_->Add(context_, server::Pass(), message, stream_host_->mesh_options().dimension);
    if (message.more()) return "";
    EditJob job = std::move(partial_->job);
    partial_.reset();
    return Run(stream_host_->id(), std::move(job));
  }

  void EndStream() {
    partial_.reset();
    stream_host_ = nullptr;
  }

  std::string Do(const v1::WatchRequest& request) {
    const auto host = registry_.Find(request.mesh());
    if (!host.ok()) return CheckRefusal(host.status());
    const auto start = server::DecodeStart(request);
    if (!start.ok()) return CheckRefusal(start.status());
    auto regions = server::DecodeRegions(request.regions());
    if (!regions.ok()) return CheckRefusal(regions.status());
    const auto subscription = (*host)->hub()->Subscribe(*start, [] {});
    if (!subscription.ok()) return CheckRefusal(subscription.status());
    const bool filtered = !regions->IsEverything();
    server::WatchFilter filter(*std::move(regions));
    client::MeshReplica replica;
    std::string problem;
    std::uint64_t at = start->revision.value_or(0);
    while (const auto item = NextItem(**subscription)) {
      if (!start->revision.has_value()) {
        const absl::Status sent = Send(filtered ? filter.Apply(*item) : *item, replica);
        if (!sent.ok()) problem = "a watch: " + sent.ToString();
      } else if (const auto* diff = std::get_if<std::shared_ptr<const MeshDiff>>(&*item)) {
        if ((*diff)->from_revision != at) problem = "a resumed watch has a gap";
        at = (*diff)->to_revision;
      } else if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&*item)) {
        at = (*mesh)->revision;
      }
    }
    (*subscription)->Cancel();
    const std::uint64_t reached = start->revision.has_value() ? at : replica.revision();
    if (problem.empty() && reached != (*host)->head().revision) problem = "a watch has no end";
    return problem;
  }

  std::string Do(const v1::GetSnapshotRequest& request) {
    const auto host = registry_.Find(request.mesh());
    if (!host.ok()) return CheckRefusal(host.status());
    const auto regions = server::DecodeRegions(request.regions());
    if (!regions.ok()) return CheckRefusal(regions.status());
    const auto mesh = (*host)->store()->Latest();
    if (!mesh.ok()) return mesh.status().ToString();
    const auto inside = std::make_shared<const Mesh>(mesh_data::OnlyInside(**mesh, *regions));
    client::MeshReplica replica;
    const absl::Status sent = Send(regions->IsEverything() ? *mesh : inside, replica);
    return sent.ok() ? "" : "a snapshot: " + sent.ToString();
  }

  std::string Do(const v1::LocatePointsRequest& request) {
    const auto host = registry_.Find(request.mesh());
    if (!host.ok()) return CheckRefusal(host.status());
    const int dimension = (*host)->mesh_options().dimension;
    const absl::Status good = server::CheckLocate(request, dimension);
    if (!good.ok()) return CheckRefusal(good);
    std::promise<std::size_t> rows;
    const absl::Status posted =
        (*host)->Locate({request.coordinates().begin(), request.coordinates().end()}, nullptr,
                        [&rows](const absl::StatusOr<MeshHost::LocateAnswer>& answer) {
                          rows.set_value(answer.ok() ? answer->simplices.size() : 0);
                        });
    if (!posted.ok()) return CheckRefusal(posted);
    const auto points = static_cast<std::size_t>(request.coordinates_size() / dimension);
    const std::size_t corners = static_cast<std::size_t>(dimension) + 1;
    return test::WaitFor("an answer", rows) == points * corners ? "" : "a point got no answer";
  }

  std::string Do(const v1::DeleteMeshRequest& request) {
    const auto host = registry_.Find(request.mesh());
    const absl::Status status = registry_.Delete(request.mesh());
    if (!status.ok()) return host.ok() ? "it was there" : CheckRefusal(status);
    meshes_.erase((*host)->id());
    if (stream_host_ == *host) EndStream();
    return "";
  }

  std::string CompareAll() const {
    for (const auto& [id, followed] : meshes_) {
      std::string problem = followed.CompareWithScratch();
      if (!problem.empty()) return id + ": " + problem;
    }
    return "";
  }

 private:
  // Submits the batch and waits.
  std::string Run(const std::string& id, EditJob job) {
    const auto found = meshes_.find(id);
    if (found == meshes_.end()) return "";  // of a stream to a mesh that is gone
    MeshHost& host = found->second.host();
    const server::Head before = host.head();
    const bool validate_only = job.validate_only;
    std::promise<absl::StatusOr<EditOutcome>> answer;
    job.done = [&answer](absl::StatusOr<EditOutcome> outcome) {
      answer.set_value(std::move(outcome));
    };
    if (const absl::Status s = host.Apply(std::move(job)); !s.ok()) return CheckRefusal(s);
    const absl::StatusOr<EditOutcome> outcome = test::WaitFor("an outcome", answer);
    const server::Head after = host.head();
    const bool same = after.revision == before.revision && after.hash == before.hash;
    if (!outcome.ok()) return same ? CheckRefusal(outcome.status()) : "a refused batch changed it";
    if ((validate_only || outcome->replayed) && !same) return "it should not have changed";
    codec::DiffFragmenter fragmenter(outcome->diff, outcome->columns_omitted, kFragmentBytes);
    codec::DiffAssembler assembler;
    v1::MeshDiff message;
    while (fragmenter.Next(&message)) {
      if (const auto s = assembler.Add(message).status(); !s.ok()) return "a diff: " + s.ToString();
    }
    return found->second.CatchUp(!same);
  }

  const server::ServerConfig config_ = Config();
  server::WorkerPool writers_{1}, readers_{1};
  server::ServerMetrics metrics_;
  const DynamicMesh* made_ = nullptr;  // the last
  MeshRegistry registry_{config_,
                         [this](const MeshOptions& options, const ApplyOptions& apply) {
                           auto mesh = DynamicMesh::Create(options, apply);
                           if (mesh.ok()) made_ = mesh->get();
                           return mesh;
                         },
                         &writers_,
                         &readers_,
                         nullptr,
                         &metrics_};
  server::ServiceContext context_{config_,   &registry_, &writers_, &readers_,
                                  &readers_, &metrics_,  nullptr,   absl::UnixEpoch()};
  std::map<std::string, Followed> meshes_;
  MeshRegistry::HostPtr stream_host_;
  std::optional<server::PartialBatch> partial_;
};

// Parses like the server. Messages that do not parse never reach it.
template <typename Message, typename Do>
std::string Parsed(const std::string& body, Do use) {
  Message message;
  return message.ParseFromString(body) ? use(message) : "";
}

// A mesh with options of the packing, unless it is there, and batches.
template <int D>
std::string DoPacked(Service& service, std::string_view body) {
  Unpacker<D> unpacker(body);
  v1::CreateMeshRequest create;
  create.set_mesh_id(D == 2 ? "plane" : "space");
  codec::EncodeOptions(unpacker.Options(), create.mutable_options());
  create.mutable_options()->set_max_vertices(D == 2 ? kMostVertices : kMostVerticesInSpace);
  std::string problem = service.Do(create);
  for (std::size_t n = 0; problem.empty() && !unpacker.AtEnd() && n < kMostPacked; ++n) {
    v1::ApplyEditsRequest request;
    request.set_mesh(D == 2 ? "meshes/plane" : "meshes/space");
    for (const Edit& edit : unpacker.Batch()) codec::EncodeEdit(edit, D, request.add_edits());
    problem = Parsed<v1::ApplyEditsRequest>(request.SerializeAsString(),
                                            [&](const auto& m) { return service.DoEdits(m); });
  }
  return problem;
}

std::string DoPart(Service& service, int kind, const std::string& body) {
  const auto use = [&](const auto& message) { return service.Do(message); };
  const auto edit = [&](const auto& message) { return service.DoEdits(message); };
  switch (kind % 12) {
    case 0:
      return Parsed<v1::CreateMeshRequest>(body, use);
    case 1:
      return Parsed<v1::AddFeaturesRequest>(body, edit);
    case 2:
      return Parsed<v1::RemoveFeaturesRequest>(body, edit);
    case 3:
      return Parsed<v1::ApplyEditsRequest>(body, edit);
    case 4:
    case 5:
      return Parsed<v1::EditBatch>(body, use);
    case 6:
      return Parsed<v1::WatchRequest>(body, use);
    case 7:
      return Parsed<v1::LocatePointsRequest>(body, use);
    case 8:
      return Parsed<v1::GetSnapshotRequest>(body, use);
    case 9:
      service.EndStream();
      return Parsed<v1::DeleteMeshRequest>(body, use);
    case 10:
      return DoPacked<2>(service, body);
    default:
      return DoPacked<3>(service, body);
  }
}

}  // namespace

std::string FuzzRequests(std::string_view bytes) {
  static const absl::Status quiet = server::SetLogLevel("off");
  if (!quiet.ok()) return quiet.ToString();
  BeQuiet();
  Service service;
  std::size_t parts = 0;
  for (const std::string_view part : SplitFiles(bytes)) {
    if (part.empty() || ++parts > kMostParts) continue;
    const std::string problem =
        DoPart(service, static_cast<unsigned char>(part[0]), std::string(part.substr(1)));
    if (!problem.empty()) return problem;
  }
  return service.CompareAll();
}

}  // namespace dynmesh::fuzz
