// Who is calling, and whether they may: tokens and their roles, requests a second, and the right
// of streams to stay open. Knows no gRPC. Thread-safe; admitting a call costs a hash of its token
// and a comparison with each that there is.
//
// Without a file of tokens everybody may do everything. With one, it is read again when it
// changed and then stayed the same for a second: one that is being written may be empty so far. One
// that is gone or bad by then is logged, and the tokens stay what they were. A token
// that is taken out, or loses a role, ends the streams that need it at once; calls that end by
// themselves do so.
#ifndef DYNMESH_SERVER_ACCESS_ACCESS_H_
#define DYNMESH_SERVER_ACCESS_ACCESS_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/access/file_stamp.h"
#include "server/access/rate_limit.h"
#include "server/access/tokens.h"

namespace dynmesh::server {

// What a call tells of itself.
struct Caller {
  std::optional<absl::string_view> authorization;  // the metadata of that name
  absl::string_view address;                       // without a port
};

// One who was let in. Copies share the bucket.
class Pass {
 public:
  // PERMISSION_DENIED (ROLE_MISSING); INVALID_ARGUMENT (BAD_NAME) for a malformed name.
  absl::Status Check(Role role, absl::string_view mesh_name) const;
  absl::Status CheckId(Role role, absl::string_view mesh_id) const;
  bool Allows(Role role, absl::string_view mesh_id) const;
  // One more request: RESOURCE_EXHAUSTED (RATE_LIMIT, with RetryInfo).
  absl::Status TakeRequest() const;
  // "" without tokens.
  std::string name() const { return token_ == nullptr ? "" : token_->name; }
  // For people: "token lab" or, without tokens, "address ipv4:10.0.0.7".
  const std::string& client() const { return client_; }

 private:
  friend class Access;
  std::string client_;
  std::shared_ptr<const Token> token_;  // null: everything is allowed
  std::shared_ptr<RateBucket> bucket_;  // null: at any rate
};

class Access {
 public:
  // A stream that is open, until destroyed or Closed. Its `cancel` is not called after that.
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

  // INVALID_ARGUMENT if the file of tokens cannot be used. Empty: none.
  static absl::StatusOr<std::unique_ptr<Access>> Create(const std::string& tokens_file,
                                                        double requests_per_second);

  // Takes a request off the caller's rate. UNAUTHENTICATED (TOKEN_MISSING, TOKEN_UNKNOWN).
  absl::StatusOr<Pass> Admit(const Caller& caller);

  // Calls `cancel` when the pass no longer allows that; refused at once if it is so already.
  absl::StatusOr<Stream> Open(const Pass& pass, Role role, absl::string_view mesh_id,
                              std::function<void()> cancel);

  // Looks at the file of tokens, to read it again a second after it changed. To be called now and
  // then; `now` is that of any clock that only goes forward.
  void ReloadIfChanged(absl::Time now);
  // Reads it again in any case.
  void Reload();

 private:
  struct Entry {
    std::shared_ptr<const Token> token;
    Role role;
    std::string mesh_id;
    std::function<void()> cancel;
  };

  Access(std::string tokens_file, double requests_per_second)
      : tokens_file_(std::move(tokens_file)), rate_(requests_per_second) {}
  absl::StatusOr<TokenTable> Read() const;
  void ReadAgain(const FileStamp& stamp);
  // The token with that hash as it is now.
  std::shared_ptr<const Token> Current(const Token& token) const;

  const std::string tokens_file_;
  RateLimit rate_;
  mutable std::mutex mutex_;
  std::shared_ptr<const TokenTable> table_;  // null: no authentication
  std::map<std::uint64_t, Entry> streams_;
  std::uint64_t next_key_ = 1;
  std::mutex reload_mutex_;  // taken first
  FileStamp stamp_;          // of the file when it was read
  FileStamp last_seen_;      // of the file at the last look, and when it first looked so
  absl::Time changed_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_ACCESS_H_
