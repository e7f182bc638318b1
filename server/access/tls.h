// TLS for the server's port, from files that may be replaced while it runs.
//
// Each new connection checks the files' stamps. If they changed, the files are read and checked:
// the certificate, that the key belongs to it, the authority for clients. Valid files are used from
// then on; a failure is logged, and the previous ones stay in use. Open connections keep theirs. A
// certificate outside its validity period is used, since the clock may be wrong, but a warning is
// logged. Thread-safe.
//
// gRPC's own file watcher is not used: it does not check the files, not even that the key belongs
// to the certificate.
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
  // To be called periodically with the time of day. Reads changed files again, and warns of
  // certificates that are not valid or expire soon (certificate_watch.h).
  virtual void Look(absl::Time now) = 0;
};

// INVALID_ARGUMENT, naming flag and file, if `files` are unusable. The credentials must outlive the
// server that listens with them.
absl::StatusOr<std::shared_ptr<TlsCredentials>> MakeTlsCredentials(const TlsFiles& files);

// End of validity of the first certificate in `file`; INVALID_ARGUMENT if there is none. Reads the
// file.
absl::StatusOr<absl::Time> EndOfCertificate(const std::string& file);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_TLS_H_
