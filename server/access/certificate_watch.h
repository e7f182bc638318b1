// Logs a warning for a certificate that is not valid, or expires soon: when it comes into use, and
// repeatedly while in use. Clients refuse an invalid certificate without the server noticing. Not
// thread-safe.
#ifndef DYNMESH_SERVER_ACCESS_CERTIFICATE_WATCH_H_
#define DYNMESH_SERVER_ACCESS_CERTIFICATE_WATCH_H_

#include <optional>
#include <string>

#include "absl/time/time.h"

namespace dynmesh::server {

// Validity of a certificate, or the intersection of several.
struct Validity {
  absl::Time from = absl::InfinitePast();
  absl::Time until = absl::InfiniteFuture();

  bool Contains(absl::Time now) const { return from <= now && now < until; }
};

class CertificateWatch {
 public:
  enum class Finding { kEndsSoon, kExpired, kNotValidYet };

  // The certificates of `file` are in use from now on.
  void Use(const std::string& file, const Validity& validity);

  // The finding to log at `now`, the time of day. A new finding is due at once, then once a day;
  // for certificates that are not valid once an hour.
  std::optional<Finding> Due(absl::Time now);
  // Logs what is Due.
  void Look(absl::Time now);
  // Logs that certificates of `file` with `validity` are not valid at `now`, and that those in use
  // stay.
  static void TellRefused(const std::string& file, const Validity& validity, absl::Time now);

 private:
  std::optional<Finding> FindAt(absl::Time now) const;

  std::string file_;
  Validity validity_;
  std::optional<Finding> told_;
  absl::Time told_at_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_CERTIFICATE_WATCH_H_
