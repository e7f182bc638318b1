// Listens, and passes each new connection to gRPC while their number is within the limit.
//
// gRPC 1.51 can listen by itself, but it has no limit of connections, and after one accept() that
// failed for lack of file descriptors it never accepts again. Here an excess connection is closed
// at once, and the open ones continue. The number of open connections is derived from the process's
// file descriptors: counted now and then, and in between incremented per accept.
//
// Thread-safe: has one thread of its own. A connection costs an accept; a count costs O(open
// descriptors).
#ifndef DYNMESH_SERVER_ACCESS_ACCEPTOR_H_
#define DYNMESH_SERVER_ACCESS_ACCEPTOR_H_

#include <grpcpp/server_builder.h>

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace dynmesh::server {

// Raises this process's limit of file descriptors to its maximum, once.
void RaiseDescriptorLimit();

class Acceptor {
 public:
  using Sink = std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>;

  // Binds to all addresses of `host_port`; port 0 picks a free one. UNAVAILABLE if none can be
  // bound. Nothing is accepted before Start.
  static absl::StatusOr<std::unique_ptr<Acceptor>> Listen(const std::string& host_port,
                                                          std::uint64_t max_connections);
  // As Stop.
  ~Acceptor();

  int port() const { return port_; }
  // Passes connections to `sink`; its server must have been started. A client that acknowledges no
  // data for `silence` is disconnected.
  void Start(Sink sink, absl::Duration silence);
  // Stops accepting. To be called before the server shuts down.
  void Stop();

 private:
  Acceptor(std::vector<int> sockets, int port, std::uint64_t max_connections);
  void Run();
  void AcceptOne(int listening);
  bool IsRoom();

  const std::vector<int> sockets_;
  const int port_;
  const std::uint64_t max_connections_;
  Sink sink_;
  int silence_ms_ = 0;
  int stop_pipe_[2] = {-1, -1};
  std::thread thread_;
  // Used by the thread only.
  std::uint64_t others_ = 0;  // descriptors that are not connections
  std::uint64_t open_ = 0;    // connections; an upper bound
  absl::Time counted_ = absl::InfinitePast();
  absl::Time warned_ = absl::InfinitePast();
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_ACCEPTOR_H_
