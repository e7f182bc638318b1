#include "server/mesh_registry.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "proto/codec/status_codec.h"
#include "server/log.h"

namespace dynmesh::server {
namespace {

constexpr absl::string_view kPrefix = "meshes/";
constexpr std::size_t kMaxIdLength = 63;

absl::Status MeshError(absl::StatusCode code, const char* reason_text, absl::string_view id,
                       absl::string_view what) {
  codec::ServiceError error;
  error.reason = reason_text;
  error.metadata["mesh"] = MeshName(id);
  return codec::MakeServiceError(code, absl::StrCat(MeshName(id), " ", what), error);
}

absl::Status BadName(absl::string_view field, absl::string_view name, absl::string_view form) {
  codec::ServiceError error;
  error.reason = codec::reason::kBadName;
  error.field = std::string(field);
  return codec::MakeServiceError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat(field, " '", name.substr(0, 100), "' is not of the form ", form), error);
}

MeshHost::Options HostOptions(const ServerConfig& c) {
  MeshHost::Options options;
  options.history = {c.history_revisions, c.history_bytes};
  options.watch = {c.watch_queue, c.progress_interval};
  options.max_waiting = c.max_waiting_edits;
  options.remembered_requests = c.remembered_requests;
  return options;
}

}  // namespace

bool IsMeshId(absl::string_view id) {
  if (id.empty() || id.size() > kMaxIdLength || id[0] < 'a' || id[0] > 'z') return false;
  return std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

absl::StatusOr<std::string> ParseMeshName(absl::string_view name) {
  absl::string_view id = name;
  if (!absl::ConsumePrefix(&id, kPrefix) || !IsMeshId(id)) {
    return BadName("mesh", name, "meshes/{id} with an id [a-z][a-z0-9-]{0,62}");
  }
  return std::string(id);
}

std::string MeshName(absl::string_view id) { return absl::StrCat(kPrefix, id); }

MeshRegistry::MeshRegistry(const ServerConfig& config, MeshFactory factory, WorkerPool* writers,
                           WorkerPool* readers)
    : config_(config), factory_(std::move(factory)), writers_(writers), readers_(readers) {}

MeshRegistry::~MeshRegistry() { CloseAll(absl::UnavailableError("the server has ended")); }

absl::StatusOr<MeshRegistry::HostPtr> MeshRegistry::FindCreated(
    const std::string& id, const MeshOptions& options, const std::string& request_id) const {
  if (request_id.empty()) return HostPtr();
  const auto it = creations_.find(request_id);
  if (it == creations_.end()) return HostPtr();
  const Creation& made = it->second;
  if ((!id.empty() && id != made.id) || options != made.options) {
    return MeshError(absl::StatusCode::kAlreadyExists, codec::reason::kRequestIdReused, made.id,
                     "was made with this request_id and other content: use a new one");
  }
  return hosts_.at(made.id);
}

absl::Status MeshRegistry::CheckRoom(const std::string& id) const {
  if (!id.empty() && hosts_.contains(id)) {
    return MeshError(absl::StatusCode::kAlreadyExists, codec::reason::kMeshExists, id,
                     "exists already");
  }
  if (hosts_.size() >= config_.max_meshes) {
    codec::ServiceError error;
    error.reason = codec::reason::kMeshLimit;
    return codec::MakeServiceError(
        absl::StatusCode::kResourceExhausted,
        absl::StrCat("the server holds its limit of ", config_.max_meshes, " meshes: delete one"),
        error);
  }
  return absl::OkStatus();
}

std::string MeshRegistry::FreshId() {
  while (true) {
    std::string id = absl::StrFormat("m-%012x", random_() & 0xffffffffffffu);
    if (!hosts_.contains(id)) return id;
  }
}

absl::StatusOr<MeshRegistry::HostPtr> MeshRegistry::Create(const std::string& id,
                                                           const MeshOptions& options,
                                                           const std::string& request_id) {
  if (!id.empty() && !IsMeshId(id)) {
    return BadName("mesh_id", id, "[a-z][a-z0-9-]{0,62}");
  }
  // Looked at before the mesh is made, to spare the work, and again after.
  {
    const std::lock_guard lock(mutex_);
    auto created = FindCreated(id, options, request_id);
    if (!created.ok() || *created != nullptr) return created;
    if (absl::Status status = CheckRoom(id); !status.ok()) return status;
  }
  absl::StatusOr<std::unique_ptr<DynamicMesh>> mesh = factory_(options);
  if (!mesh.ok()) return mesh.status();

  const std::lock_guard lock(mutex_);
  auto created = FindCreated(id, options, request_id);
  if (!created.ok() || *created != nullptr) return created;
  if (absl::Status status = CheckRoom(id); !status.ok()) return status;
  const std::string final_id = id.empty() ? FreshId() : id;
  HostPtr host = MeshHost::Create(final_id, *std::move(mesh), absl::Now(), writers_, readers_,
                                  HostOptions(config_));
  hosts_.emplace(final_id, host);
  if (!request_id.empty()) creations_.emplace(request_id, Creation{final_id, options});
  Log(LogLevel::kInfo, "mesh_created", {{"mesh", final_id}, {"meshes", hosts_.size()}});
  return host;
}

absl::StatusOr<MeshRegistry::HostPtr> MeshRegistry::Find(absl::string_view name) const {
  const absl::StatusOr<std::string> id = ParseMeshName(name);
  if (!id.ok()) return id.status();
  const std::lock_guard lock(mutex_);
  const auto it = hosts_.find(*id);
  if (it == hosts_.end()) {
    return MeshError(absl::StatusCode::kNotFound, codec::reason::kMeshNotFound, *id,
                     "does not exist: create it, or list those that do");
  }
  return it->second;
}

absl::Status MeshRegistry::Delete(absl::string_view name) {
  absl::StatusOr<HostPtr> host = Find(name);
  if (!host.ok()) return host.status();
  {
    const std::lock_guard lock(mutex_);
    const auto it = hosts_.find((*host)->id());
    // Somebody else may have been faster.
    if (it == hosts_.end() || it->second != *host) {
      return MeshError(absl::StatusCode::kNotFound, codec::reason::kMeshNotFound, (*host)->id(),
                       "does not exist");
    }
    hosts_.erase(it);
    std::erase_if(creations_, [&](const auto& c) { return c.second.id == (*host)->id(); });
  }
  (*host)->Close(MeshError(absl::StatusCode::kNotFound, codec::reason::kMeshDeleted, (*host)->id(),
                           "was deleted"));
  Log(LogLevel::kInfo, "mesh_deleted", {{"mesh", (*host)->id()}});
  return absl::OkStatus();
}

std::vector<MeshRegistry::HostPtr> MeshRegistry::List(absl::string_view after,
                                                      std::size_t limit) const {
  const std::lock_guard lock(mutex_);
  std::vector<HostPtr> found;
  for (auto it = hosts_.upper_bound(after); it != hosts_.end() && found.size() < limit; ++it) {
    found.push_back(it->second);
  }
  return found;
}

std::size_t MeshRegistry::size() const {
  const std::lock_guard lock(mutex_);
  return hosts_.size();
}

std::vector<MeshRegistry::HostPtr> MeshRegistry::All() const {
  return List("", static_cast<std::size_t>(-1));
}

std::size_t MeshRegistry::watchers() const {
  std::size_t sum = 0;
  for (const HostPtr& host : All()) sum += host->hub()->size();
  return sum;
}

void MeshRegistry::Tick(absl::Time now) {
  for (const HostPtr& host : All()) host->hub()->Tick(now);
}

void MeshRegistry::CloseAll(const absl::Status& status) {
  for (const HostPtr& host : All()) host->Close(status);
}

void MeshRegistry::CloseWatches(const absl::Status& status) {
  for (const HostPtr& host : All()) host->hub()->Close(status);
}

}  // namespace dynmesh::server
