// Authenticates callers: tokens and their roles, the rate limit, and the rights of open streams.
// Does not depend on gRPC. Thread-safe. Admitting a call costs one hash of its token and a
// comparison with each known token.
//
// Without a token file every client may do everything. The file is read again when it changed and
// then stayed the same for a second, since a file that is being written may be incomplete. If it is
// missing or invalid then, this is logged and the tokens stay. If a token is removed or loses a
// role, the streams that need it end at once; other calls run to their end.
#ifndef DYNMESH_SERVER_ACCESS_ACCESS_H_
#define DYNMESH_SERVER_ACCESS_ACCESS_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/access/file_stamp.h"
#include "server/access/rate_limit.h"
#include "server/access/tokens.h"

namespace dynmesh::server {

// The identity that a call presents.
struct Caller {
  std::optional<absl::string_view> authorization;  // the metadata of that name
  absl::string_view address;                       // without a port
};

// An authenticated caller. Copies share the bucket.
class Pass {
 public:
  // PERMISSION_DENIED (ROLE_MISSING); INVALID_ARGUMENT (BAD_NAME) for a malformed name.
  absl::Status Check(Role role, absl::string_view mesh_name) const;
  absl::Status CheckId(Role role, absl::string_view mesh_id) const;
  // PERMISSION_DENIED (ROLE_MISSING) unless the caller has the role on some mesh, be there one or
  // not.
  absl::Status CheckSome(Role role) const;
  bool Allows(Role role, absl::string_view mesh_id) const;
  // Counts one more request: RESOURCE_EXHAUSTED (RATE_LIMIT, with RetryInfo).
  absl::Status TakeRequest() const;
  // "" without tokens.
  std::string name() const { return token_ == nullptr ? "" : token_->name; }
  // For messages: "token lab" or, without tokens, "address ipv4:10.0.0.7".
  const std::string& client() const { return client_; }

 private:
  friend class Access;
  absl::Status Missing(Role role, const std::string& mesh, absl::string_view where) const;

  std::string client_;
  std::shared_ptr<const Token> token_;  // null: everything is allowed
  std::shared_ptr<RateBucket> bucket_;  // null: no limit
};

class Access {
 public:
  // Ends a stream. `why`: a reason, as TOKEN_UNKNOWN, a colon and a text.
  using Cancel = std::function<void(const std::string& why)>;

  // An open stream, until destroyed or Closed. Its `cancel` is not called after that.
  class Stream {
   public:
    Stream() = default;
    Stream(Stream&& other) noexcept { *this = std::move(other); }
    Stream& operator=(Stream&& other) noexcept;
    ~Stream() { Close(); }
    void Close();

   private:
    friend class Access;
    Access* access_ = nullptr;
    std::uint64_t key_ = 0;
  };

  // INVALID_ARGUMENT if the token file is unusable. An empty path: no tokens.
  static absl::StatusOr<std::unique_ptr<Access>> Create(const std::string& tokens_file,
                                                        double requests_per_second);

  // There is more than one token, so that clients can be told apart.
  bool has_several_clients() const { return tokens_.load(std::memory_order_relaxed) > 1; }

  // Counts a request of the caller. UNAUTHENTICATED (TOKEN_MISSING, TOKEN_UNKNOWN).
  absl::StatusOr<Pass> Admit(const Caller& caller);

  // Calls `cancel` when the pass loses the role on the mesh. Refuses at once if it does not have
  // it.
  absl::StatusOr<Stream> Open(const Pass& pass, Role role, absl::string_view mesh_id,
                              Cancel cancel);

  // Checks the token file, and reads it again a second after a change. To be called periodically;
  // `now` is from a monotonic clock.
  void ReloadIfChanged(absl::Time now);
  // Reads it again unconditionally.
  void Reload();

 private:
  struct Entry {
    std::shared_ptr<const Token> token;
    Role role;
    std::string mesh_id;
    Cancel cancel;
  };

  Access(std::string tokens_file, double requests_per_second)
      : tokens_file_(std::move(tokens_file)), rate_(requests_per_second) {}
  absl::StatusOr<TokenTable> Read() const;
  void SetTable(TokenTable table) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ReadAgain(const FileStamp& stamp) ABSL_EXCLUSIVE_LOCKS_REQUIRED(reload_mutex_)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // The present token with that hash.
  std::shared_ptr<const Token> Current(const Token& token) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string tokens_file_;
  RateLimit rate_;
  mutable Mutex mutex_;
  std::shared_ptr<const TokenTable> table_ ABSL_GUARDED_BY(mutex_);  // null: no authentication
  std::atomic<std::size_t> tokens_{0};                               // in table_
  std::map<std::uint64_t, Entry> streams_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t next_key_ ABSL_GUARDED_BY(mutex_) = 1;
  Mutex reload_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);
  FileStamp stamp_ ABSL_GUARDED_BY(reload_mutex_);  // of the file when it was last read
  // Of the file at the last check; changed_ is when it was first seen.
  FileStamp last_seen_ ABSL_GUARDED_BY(reload_mutex_);
  absl::Time changed_ ABSL_GUARDED_BY(reload_mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_ACCESS_H_
