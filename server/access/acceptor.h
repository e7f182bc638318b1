// Listens, and passes each new connection to gRPC as far as the limits of connections allow it.
//
// gRPC 1.51 can listen by itself, but it has no limit of connections, and after one accept() that
// failed for lack of file descriptors it never accepts again. Here an excess connection is closed
// at once, and the open ones continue. What one address may have is in connection_table.h.
//
// Thread-safe: has one thread of its own. A connection costs a few system calls at its beginning
// and its end.
#ifndef DYNMESH_SERVER_ACCESS_ACCEPTOR_H_
#define DYNMESH_SERVER_ACCESS_ACCEPTOR_H_

#include <grpcpp/server_builder.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/access/connection_table.h"
#include "server/access/rare_line.h"

namespace dynmesh::server {

// Raises this process's limit of file descriptors to its maximum, once.
void RaiseDescriptorLimit();

class Acceptor {
 public:
  using Sink = std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>;

  struct Limits {
    std::uint64_t connections = 20'000;
    ConnectionTable::Limits of_address;
  };

  // Binds to all addresses of `host_port`; port 0 picks a free one. UNAVAILABLE if none can be
  // bound. Nothing is accepted before Start.
  static absl::StatusOr<std::unique_ptr<Acceptor>> Listen(const std::string& host_port,
                                                          const Limits& limits);
  // As Stop. To be destroyed after the server: calls use it.
  ~Acceptor();

  int port() const { return port_; }
  // Passes connections to `sink`; its server must have been started. A client that acknowledges no
  // data for `silence` is disconnected.
  void Start(Sink sink, absl::Duration silence);
  // Stops accepting. To be called before the server shuts down.
  void Stop();

  // By any thread: how a call of `peer`, as gRPC names it, ended.
  bool WantsAnswered() const { return table_.HasUnanswered(); }
  void Answered(absl::string_view peer);
  void Wasted(absl::string_view peer);

  // Not counting connections that have been closed.
  ConnectionTable::Counts counts() {
    table_.Sweep();
    return table_.counts();
  }

 private:
  Acceptor(std::vector<int> sockets, int port, const Limits& limits);
  void Run();
  void AcceptAll(int listening);
  bool AcceptOne(int listening);
  void LetIn(const ConnectionTable::Waiting& connection);
  bool IsRoom();
  void Wake() const;

  const std::vector<int> sockets_;
  const int port_;
  const Limits limits_;
  ConnectionTable table_;
  Sink sink_;
  int silence_ms_ = 0;
  int wake_ = -1;  // an eventfd
  std::atomic<bool> stopping_{false};
  std::thread thread_;
  std::uint64_t others_ = 0;                 // descriptors that are not connections
  absl::Time swept_ = absl::InfinitePast();  // used by the thread

  RareLine full_line_, cut_line_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_ACCEPTOR_H_
