// Warns, in the log, of a certificate that is not valid, or soon no more: when it comes into use,
// and while it is. Clients refuse such a one, and the server is the last to know. Not thread-safe.
#ifndef DYNMESH_SERVER_ACCESS_CERTIFICATE_WATCH_H_
#define DYNMESH_SERVER_ACCESS_CERTIFICATE_WATCH_H_

#include <optional>
#include <string>

#include "absl/time/time.h"

namespace dynmesh::server {

// When a certificate, or each of some, is valid.
struct Validity {
  absl::Time from = absl::InfinitePast();
  absl::Time until = absl::InfiniteFuture();
};

class CertificateWatch {
 public:
  enum class Finding { kEndsSoon, kExpired, kNotValidYet };

  // The certificates of `file` are in use from now on.
  void Use(const std::string& file, const Validity& validity);

  // What is to be told at `now`, the time of day: a finding at once, then once a day, of those that
  // are not valid once an hour.
  std::optional<Finding> Due(absl::Time now);
  // Due, told.
  void Look(absl::Time now);

 private:
  std::optional<Finding> FindAt(absl::Time now) const;

  std::string file_;
  Validity validity_;
  std::optional<Finding> told_;
  absl::Time told_at_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_CERTIFICATE_WATCH_H_
