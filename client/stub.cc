#include <iterator>
#include <random>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/stub_internal.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/metadata.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::client {
namespace {

// A server that names ever new ones does not make the client grow.
constexpr std::size_t kMostServers = 256;

// HOST:PORT, and not a name of gRPC for something else, as of a socket in a folder.
bool IsAddress(absl::string_view text) {
  return !text.empty() && text.size() <= 300 && text[0] != ':' &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return c > ' ' && c < 0x7f && c != '/' && c != ','; });
}

}  // namespace

Stub::Stub(const std::string& addresses, std::shared_ptr<grpc::ChannelCredentials> credentials,
           const grpc::ChannelArguments& arguments, const std::string& token, bool from_followers)
    : credentials_(std::move(credentials)),
      arguments_(arguments),
      authorization_(token.empty() ? "" : absl::StrCat("Bearer ", token)),
      from_followers_(from_followers) {
  for (const absl::string_view address : absl::StrSplit(addresses, ',', absl::SkipWhitespace())) {
    known_.emplace_back(absl::StripAsciiWhitespace(address));
  }
  if (known_.empty()) known_.push_back(addresses);  // gRPC reports it
}

Stub::ServerPtr Stub::AtLocked(const std::string& address) {
  ServerPtr& server = servers_[address];
  if (server == nullptr) {
    auto channel = grpc::CreateCustomChannel(address, credentials_, arguments_);
    auto service = v1::MeshService::NewStub(channel);
    server = std::make_shared<Server>(Server{address, std::move(channel), std::move(service)});
  }
  return server;
}

Stub::ServerPtr Stub::Of(const std::string& mesh) {
  const MutexLock lock(mutex_);
  const auto route = mesh.empty() ? routes_.end() : routes_.find(mesh);
  return AtLocked(route == routes_.end() ? known_[first_] : route->second);
}

void Stub::Prepare(grpc::ClientContext& context, absl::Duration timeout, int redirects) const {
  if (!authorization_.empty()) context.AddMetadata("authorization", authorization_);
  context.AddMetadata(codec::kRedirectsKey, absl::StrCat(redirects));
  if (timeout == absl::InfiniteDuration()) return;
  context.set_deadline(std::chrono::system_clock::now() + absl::ToChronoNanoseconds(timeout));
}

void Stub::Forget(const std::string& key) {
  if (!from_followers_) return;
  const MutexLock lock(mutex_);
  routes_.erase(key);
}

void Stub::Saw(const std::string& mesh, std::uint64_t revision) {
  if (!from_followers_) return;
  const MutexLock lock(mutex_);
  std::uint64_t& seen = seen_[mesh];
  seen = std::max(seen, revision);
}

bool Stub::is_shared() const {
  const MutexLock lock(mutex_);
  return known_.size() > 1;
}

std::string Stub::AddressOtherThan(const std::string& address) const {
  thread_local std::minstd_rand random{std::random_device()()};
  std::vector<std::string> others;
  const MutexLock lock(mutex_);
  std::copy_if(known_.begin(), known_.end(), std::back_inserter(others),
               [&](const std::string& known) { return known != address; });
  return others.empty() ? "" : others[random() % others.size()];
}

bool Stub::Knows(const std::string& address) const {
  const MutexLock lock(mutex_);
  return std::find(known_.begin(), known_.end(), address) != known_.end();
}

Stub::ServerPtr Stub::At(const std::string& address) {
  const MutexLock lock(mutex_);
  return AtLocked(address);
}

void Stub::Moved(const std::string& mesh, const std::string& address) {
  const MutexLock lock(mutex_);
  routes_[mesh] = address;
}

// Another server is asked next.
void Stub::AvoidLocked(const std::string& mesh, const std::string& address) {
  if (const auto route = routes_.find(mesh); route != routes_.end() && route->second == address) {
    routes_.erase(route);
  }
  if (known_[first_] == address) first_ = (first_ + 1) % known_.size();
}

Stub::Next Stub::Learn(const std::string& mesh, const Server& asked, const absl::Status& status,
                       bool repeatable) {
  if (!absl::IsUnavailable(status)) return Next::kOver;
  const auto error = codec::GetServiceError(status);
  const std::string reason = error.has_value() ? error->reason : "";
  if (reason.empty()) connector_.Reach(asked.channel);
  const MutexLock lock(mutex_);
  if (reason == codec::reason::kNotOwner) {
    const auto owner = error->metadata.find("owner");
    if (owner == error->metadata.end() || !IsAddress(owner->second)) {
      AvoidLocked(mesh, asked.address);  // another one may know it
      return Next::kAfterPause;
    }
    if (std::find(known_.begin(), known_.end(), owner->second) == known_.end()) {
      if (known_.size() >= kMostServers) return Next::kAfterPause;
      known_.push_back(owner->second);
    }
    routes_[mesh] = owner->second;
    return owner->second == asked.address ? Next::kAfterPause : Next::kAtOnce;
  }
  if (known_.size() == 1) return Next::kOver;
  if (reason == codec::reason::kDraining || reason == codec::reason::kRecovering) {
    AvoidLocked(mesh, asked.address);
    return Next::kAfterPause;
  }
  const bool may_have_happened = reason.empty() || reason == codec::reason::kOutcomeUnknown;
  // Of a server that is cut off from its database another one gets the meshes.
  if (may_have_happened || reason == codec::reason::kJournalFailed) {
    AvoidLocked(mesh, asked.address);
  }
  return repeatable && may_have_happened ? Next::kAfterPause : Next::kOver;
}

void Stub::Resolve(const std::string& mesh, absl::Duration timeout) {
  {
    const MutexLock lock(mutex_);
    if (known_.size() == 1 || routes_.contains(mesh)) return;
  }
  v1::GetMeshRequest request;
  request.set_mesh(mesh);
  // The call that follows reports an error.
  Follow(mesh, /*repeatable=*/true, timeout, [&](Service& service, grpc::ClientContext& context) {
    v1::Mesh response;
    return codec::FromGrpcStatus(service.GetMesh(&context, request, &response));
  }).IgnoreError();
}

}  // namespace dynmesh::client
