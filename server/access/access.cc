#include "server/access/access.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "proto/codec/status_codec.h"
#include "server/base/log.h"
#include "server/base/mesh_name.h"
#include "server/base/peer.h"

namespace dynmesh::server {
namespace {

constexpr absl::Duration kSettled = absl::Seconds(1);

absl::Status Unauthenticated(const char* reason, absl::string_view client,
                             absl::string_view message) {
  codec::ServiceError error;
  error.reason = reason;
  error.metadata["client"] = std::string(client);
  return codec::MakeServiceError(absl::StatusCode::kUnauthenticated, message, error);
}

std::string WhyEnded(const std::string& token, bool is_known, Role role,
                     const std::string& mesh_id) {
  if (!is_known) {
    return absl::StrCat(codec::reason::kTokenUnknown, ": the token ", token, " was removed");
  }
  return absl::StrCat(codec::reason::kRoleMissing, ": the token ", token, " has the role ",
                      RoleName(role), " on ", MeshName(mesh_id), " no more");
}

// Nothing unless the text is "Bearer TOKEN".
std::optional<absl::string_view> BearerToken(absl::string_view authorization) {
  constexpr absl::string_view kScheme = "bearer ";
  if (!absl::StartsWithIgnoreCase(authorization, kScheme)) return std::nullopt;
  return absl::StripAsciiWhitespace(authorization.substr(kScheme.size()));
}

}  // namespace

bool Pass::Allows(Role role, absl::string_view mesh_id) const {
  return token_ == nullptr || token_->Allows(role, mesh_id);
}

absl::Status Pass::Missing(Role role, const std::string& mesh, absl::string_view where) const {
  codec::ServiceError error;
  error.reason = codec::reason::kRoleMissing;
  error.metadata["client"] = client_;
  error.metadata["role"] = RoleName(role);
  error.metadata["mesh"] = mesh;
  return codec::MakeServiceError(absl::StatusCode::kPermissionDenied,
                                 absl::StrCat("the token ", token_->name, " has not the role ",
                                              RoleName(role), " on ", where, ", which this needs"),
                                 error);
}

absl::Status Pass::CheckId(Role role, absl::string_view mesh_id) const {
  if (Allows(role, mesh_id)) return absl::OkStatus();
  const std::string mesh = mesh_id.empty() ? "meshes/*" : MeshName(mesh_id);
  return Missing(role, mesh, mesh);
}

absl::Status Pass::CheckSome(Role role) const {
  if (token_ == nullptr || token_->AllowsSome(role)) return absl::OkStatus();
  return Missing(role, "meshes/*", "any mesh");
}

absl::Status Pass::Check(Role role, absl::string_view mesh_name) const {
  if (token_ == nullptr) return absl::OkStatus();
  const absl::StatusOr<std::string> id = ParseMeshName(mesh_name);
  return id.ok() ? CheckId(role, *id) : id.status();
}

absl::Status Pass::TakeRequest() const {
  if (bucket_ == nullptr) return absl::OkStatus();
  const absl::Duration wait = bucket_->Take(absl::Now());
  if (wait == absl::ZeroDuration()) return absl::OkStatus();
  codec::ServiceError error;
  error.reason = codec::reason::kRateLimit;
  error.metadata["client"] = client_;
  error.retry_after = wait;
  return codec::MakeServiceError(absl::StatusCode::kResourceExhausted,
                                 "more requests a second than this server takes of one client: "
                                 "slow down, or send more in one batch",
                                 error);
}

Access::Stream& Access::Stream::operator=(Stream&& other) noexcept {
  Close();
  access_ = std::exchange(other.access_, nullptr);
  key_ = other.key_;
  return *this;
}

void Access::Stream::Close() {
  if (access_ == nullptr) return;
  const MutexLock lock(access_->mutex_);
  access_->streams_.erase(key_);
  access_ = nullptr;
}

absl::StatusOr<std::unique_ptr<Access>> Access::Create(const std::string& tokens_file,
                                                       double requests_per_second) {
  std::unique_ptr<Access> access(new Access(tokens_file, requests_per_second));
  if (tokens_file.empty()) return access;
  const FileStamp stamp = StampOf(tokens_file);
  absl::StatusOr<TokenTable> table = access->Read();
  if (!table.ok()) return table.status();
  {
    const MutexLock reloading(access->reload_mutex_);
    access->stamp_ = stamp;
    const MutexLock lock(access->mutex_);
    access->SetTable(*std::move(table));
  }
  return access;
}

absl::StatusOr<TokenTable> Access::Read() const {
  const absl::StatusOr<std::string> text = ReadSmallFile("tokens", tokens_file_);
  if (!text.ok()) return text.status();
  absl::StatusOr<TokenTable> table = TokenTable::Parse(*text);
  if (table.ok()) return table;
  return absl::InvalidArgumentError(
      absl::StrCat("tokens: ", tokens_file_, ": ", table.status().message()));
}

void Access::SetTable(TokenTable table) {
  tokens_ = table.size();
  table_ = std::make_shared<const TokenTable>(std::move(table));
}

absl::StatusOr<Pass> Access::Admit(const Caller& caller) {
  std::shared_ptr<const TokenTable> table;
  {
    const MutexLock lock(mutex_);
    table = table_;
  }
  Pass pass;
  pass.client_ = ClientAt(caller.address);
  absl::Status refused;
  if (table == nullptr) {
  } else if (!caller.authorization.has_value()) {
    refused = Unauthenticated(codec::reason::kTokenMissing, pass.client_,
                              "this server requires a token: metadata authorization: Bearer TOKEN "
                              "(dynmesh --token-file, or DYNMESH_TOKEN)");
  } else {
    const auto shown = BearerToken(*caller.authorization);
    if (shown.has_value()) pass.token_ = table->Find(codec::HashToken(*shown));
    if (pass.token_ == nullptr) {
      refused = Unauthenticated(codec::reason::kTokenUnknown, pass.client_,
                                "this server knows no such token");
    } else {
      pass.client_ = absl::StrCat("token ", pass.token_->name);
    }
  }
  pass.bucket_ = rate_.BucketOf(pass.client_, absl::Now());
  // Refused calls count too, so that guessing tokens is limited.
  if (absl::Status status = pass.TakeRequest(); !status.ok()) return status;
  if (!refused.ok()) return refused;
  return pass;
}

std::shared_ptr<const Token> Access::Current(const Token& token) const {
  return table_->Find(token.hash);
}

absl::StatusOr<Access::Stream> Access::Open(const Pass& pass, Role role, absl::string_view mesh_id,
                                            Cancel cancel) {
  Stream stream;
  if (pass.token_ == nullptr) return stream;
  const MutexLock lock(mutex_);
  // The tokens may have been reloaded since the pass was made.
  Pass now;
  now.client_ = pass.client_;
  now.token_ = Current(*pass.token_);
  if (now.token_ == nullptr) {
    return Unauthenticated(codec::reason::kTokenUnknown, pass.client_, "the token was removed");
  }
  if (absl::Status status = now.CheckId(role, mesh_id); !status.ok()) return status;
  stream.access_ = this;
  stream.key_ = next_key_++;
  streams_.emplace(stream.key_, Entry{now.token_, role, std::string(mesh_id), std::move(cancel)});
  return stream;
}

void Access::ReloadIfChanged(absl::Time now) {
  if (tokens_file_.empty()) return;
  const MutexLock reloading(reload_mutex_);
  const FileStamp stamp = StampOf(tokens_file_);
  if (std::exchange(last_seen_, stamp) != stamp) changed_ = now;
  if (stamp != stamp_ && now - changed_ >= kSettled) ReadAgain(stamp);
}

void Access::Reload() {
  if (tokens_file_.empty()) return;
  const MutexLock reloading(reload_mutex_);
  ReadAgain(StampOf(tokens_file_));
}

void Access::ReadAgain(const FileStamp& stamp) {
  stamp_ = stamp;
  absl::StatusOr<TokenTable> table = Read();
  if (!table.ok()) {
    Log(LogLevel::kError, "tokens_reload_failed",
        {{"error", table.status().message()}, {"message", "the former tokens stay"}});
    return;
  }
  const std::size_t tokens = table->size();
  std::size_t ended = 0;
  {
    const MutexLock lock(mutex_);
    SetTable(*std::move(table));
    for (auto& [key, entry] : streams_) {
      const std::shared_ptr<const Token> token = Current(*entry.token);
      if (token != nullptr && token->Allows(entry.role, entry.mesh_id)) continue;
      // Under the lock, so that the stream still exists.
      entry.cancel(WhyEnded(entry.token->name, token != nullptr, entry.role, entry.mesh_id));
      ++ended;
    }
  }
  Log(LogLevel::kInfo, "tokens_reloaded", {{"tokens", tokens}, {"streams_ended", ended}});
}

}  // namespace dynmesh::server
