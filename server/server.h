// A whole server: listens, serves, drains. Thread-safe but for destruction.
#ifndef DYNMESH_SERVER_SERVER_H_
#define DYNMESH_SERVER_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/config/config.h"
#include "server/journal/journal.h"
#include "server/meshes/mesh_host.h"
#include "server/meshes/mesh_registry.h"

namespace dynmesh::server {

class Server {
 public:
  // Serves when it returns. INVALID_ARGUMENT for a bad config, UNAVAILABLE if the
  // address cannot be had or the journal not be read. Meshes are made by `factory`. With a journal,
  // its meshes are there again, and edits answered when it has them; else nothing is kept. While
  // they are made again, the port is open and calls are answered UNAVAILABLE (RECOVERING).
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerConfig& config,
                                                       MeshFactory factory,
                                                       std::unique_ptr<Journal> journal = nullptr);
  // Cuts off what is still under way; call Drain first to be polite.
  ~Server();

  int port() const;
  std::string address() const;  // host:port with the port chosen

  // Health says NOT_SERVING, new work is refused (UNAVAILABLE), watches end, what is
  // under way ends, at most for `limit`; what is not done by then is cancelled, and
  // changes nothing. True if all ended by itself. Returns when nothing runs any more. Connections
  // without calls are told to go (GOAWAY) and closed a moment later; they do not hold it up.
  bool Drain(absl::Duration limit);

  // Reads the file of tokens again; without being told to, it does when the file changed.
  void Reload();

  MeshRegistry& registry();

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_SERVER_H_
