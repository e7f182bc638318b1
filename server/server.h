// A whole server: listens, serves, drains. Thread-safe except destruction.
#ifndef DYNMESH_SERVER_SERVER_H_
#define DYNMESH_SERVER_SERVER_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/access/connection_table.h"
#include "server/config/config.h"
#include "server/http/http_server.h"
#include "server/http/static_files.h"
#include "server/journal/journal.h"
#include "server/meshes/build_pool.h"
#include "server/meshes/mesh_host.h"
#include "server/meshes/mesh_registry.h"

namespace dynmesh::server {

class Server {
 public:
  // Returns when the server serves. Meshes are made by `factory`. INVALID_ARGUMENT for a bad
  // `config`, UNAVAILABLE if the address or the journal is not available. With a `journal`, its
  // meshes are recovered, and edits are answered after the journal has them; without one, nothing
  // outlives the process. During recovery the port is open and calls are answered UNAVAILABLE
  // (RECOVERING). Builds are made by `builder`; without one, BuildMesh is UNIMPLEMENTED. `page`:
  // files that are answered over HTTP, too.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerConfig& config,
                                                       MeshFactory factory,
                                                       std::unique_ptr<Journal> journal = nullptr,
                                                       MeshBuilder builder = nullptr,
                                                       absl::Span<const StaticFile> page = {});
  // Cuts off running calls; call Drain first to let them end.
  ~Server();

  int port() const;
  std::string address() const;       // host:port with the chosen port
  std::string http_address() const;  // the same of HTTP; empty: none

  // Health becomes NOT_SERVING, new work is refused (UNAVAILABLE), watches and running builds end,
  // and other running work has up to `limit` to end. After that it is cancelled and changes
  // nothing; only the write that the disk or the database has is waited for, however long it takes.
  // True if all ended in time. Returns when nothing runs any more. Connections without calls get a
  // GOAWAY and are closed a moment later; Drain does not wait for them.
  bool Drain(absl::Duration limit);

  // Reads the token file again. A change of the file is also noticed without this.
  void Reload();

  MeshRegistry& registry();
  ConnectionTable::Counts connections() const;
  HttpServer::Counts http_counts() const;

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_SERVER_H_
