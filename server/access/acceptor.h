// Listens, and hands each new connection to gRPC, as long as there are not too many.
//
// gRPC 1.51 can listen by itself, but knows no limit of connections, and after one accept() that
// failed for want of file descriptors it never accepts again. Here a connection too many is
// closed at once, and those that there are go on. How many are open is told by the process's file
// descriptors: counted anew now and then, and in between by what was accepted.
//
// Thread-safe: one thread of its own. A connection costs an accept; counting, a look at each open
// descriptor.
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

// Lets this process have as many file descriptors as it may, once.
void RaiseDescriptorLimit();

class Acceptor {
 public:
  using Sink = std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor>;

  // Binds to all that host:port stands for; port 0 to one that is free. UNAVAILABLE if that
  // cannot be had. Nothing is accepted before Start.
  static absl::StatusOr<std::unique_ptr<Acceptor>> Listen(const std::string& host_port,
                                                          std::uint64_t max_connections);
  // As Stop.
  ~Acceptor();

  int port() const { return port_; }
  // To the server that the sink is of, which has been started. A client that does not take what
  // it is sent for `silence` is gone.
  void Start(Sink sink, absl::Duration silence);
  // Accepts no more. Before the server is shut down.
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
  // The thread's.
  std::uint64_t others_ = 0;  // descriptors that are no connections
  std::uint64_t open_ = 0;    // connections, at most
  absl::Time counted_ = absl::InfinitePast();
  absl::Time warned_ = absl::InfinitePast();
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_ACCEPTOR_H_
