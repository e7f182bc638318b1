// The meshes of a server, by id. Thread-safe.
#ifndef DYNMESH_SERVER_MESH_REGISTRY_H_
#define DYNMESH_SERVER_MESH_REGISTRY_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/config.h"
#include "server/mesh_host.h"

namespace dynmesh::server {

// "meshes/{id}" to id and back. INVALID_ARGUMENT (BAD_NAME) if it is no such name.
absl::StatusOr<std::string> ParseMeshName(absl::string_view name);
std::string MeshName(absl::string_view id);
bool IsMeshId(absl::string_view id);

class MeshRegistry {
 public:
  using HostPtr = std::shared_ptr<MeshHost>;

  // The pools outlive the registry.
  MeshRegistry(const ServerConfig& config, MeshFactory factory, WorkerPool* writers,
               WorkerPool* readers);
  // As CloseAll.
  ~MeshRegistry();

  // Makes a mesh; an empty id lets the registry choose. ALREADY_EXISTS (MESH_EXISTS),
  // unless it was made with the same non-empty request_id and options: then that one.
  // RESOURCE_EXHAUSTED (MESH_LIMIT). May take as long as making an empty mesh.
  absl::StatusOr<HostPtr> Create(const std::string& id, const MeshOptions& options,
                                 const std::string& request_id);

  // NOT_FOUND (MESH_NOT_FOUND); INVALID_ARGUMENT for a malformed name.
  absl::StatusOr<HostPtr> Find(absl::string_view name) const;
  absl::Status Delete(absl::string_view name);

  // At most `limit` meshes with ids greater than `after`, by id.
  std::vector<HostPtr> List(absl::string_view after, std::size_t limit) const;

  std::size_t size() const;
  std::size_t watchers() const;
  void Tick(absl::Time now);
  // Ends all watches and refuses what waits, with `status`.
  void CloseAll(const absl::Status& status);
  void CloseWatches(const absl::Status& status);

 private:
  struct Creation {
    std::string id;
    MeshOptions options;
  };

  absl::StatusOr<HostPtr> FindCreated(const std::string& id, const MeshOptions& options,
                                      const std::string& request_id) const;
  absl::Status CheckRoom(const std::string& id) const;
  std::string FreshId();
  std::vector<HostPtr> All() const;

  const ServerConfig config_;
  const MeshFactory factory_;
  WorkerPool* const writers_;
  WorkerPool* const readers_;

  mutable std::mutex mutex_;
  std::map<std::string, HostPtr, std::less<>> hosts_;
  std::map<std::string, Creation> creations_;  // by request_id, of meshes that exist
  std::mt19937_64 random_{std::random_device{}()};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESH_REGISTRY_H_
