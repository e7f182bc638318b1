// TLS for the server's port, from files that may be replaced while it runs.
//
// At every new connection the files' stamps are looked at. If they changed, the files are read
// and checked: certificate, key that belongs to it, authority for clients. What passes is used
// from then on; what does not is logged, and what was used before stays. Connections that are
// open keep what they began with. A certificate that is not valid is used, as a clock may be wrong,
// but the log warns of it. Thread-safe.
//
// gRPC's own watcher of files is not used: it hands on what it read unchecked, a certificate with
// another one's key too.
#ifndef DYNMESH_SERVER_ACCESS_TLS_H_
#define DYNMESH_SERVER_ACCESS_TLS_H_

#include <grpcpp/security/server_credentials.h>

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace dynmesh::server {

struct TlsFiles {
  std::string certificate;  // PEM, the chain after it; empty: no TLS
  std::string key;          // PEM, without a password
  std::string client_ca;    // PEM; if given, clients must show a certificate that it signed

  bool enabled() const { return !certificate.empty(); }
};

class TlsCredentials : public grpc::ServerCredentials {
 public:
  // To be called now and then with the time of day: reads files again that changed, and warns of
  // certificates that are not valid, or soon no more (certificate_watch.h).
  virtual void Look(absl::Time now) = 0;
};

// INVALID_ARGUMENT, naming flag and file, if they cannot be used. The credentials outlive the
// server that listens with them.
absl::StatusOr<std::shared_ptr<TlsCredentials>> MakeTlsCredentials(const TlsFiles& files);

// When the certificate in a file, the first if it has several, is no longer valid; INVALID_ARGUMENT
// if there is none. Reads the file.
absl::StatusOr<absl::Time> EndOfCertificate(const std::string& file);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_TLS_H_
