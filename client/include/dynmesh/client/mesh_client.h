// The client library: a server's meshes as typed calls. Errors are absl::Status with a
// machine-readable detail: codec::GetServiceError(status) has reason, features, field
// (dynmesh/codec/service_error.h).
//
//   auto client = MeshClient::Connect("127.0.0.1:7878");
//   auto mesh = client->CreateMesh("plate", options);
//   auto result = client->Apply("plate", {Edit::Add(Feature::Point(1, 0.5, 0.5))});
//   auto replica = client->Watch("plate", {}, nullptr);   // follows the mesh
//
// Meshes are named by id ("plate") or by resource name ("meshes/plate"). Thread-safe.
#ifndef DYNMESH_CLIENT_MESH_CLIENT_H_
#define DYNMESH_CLIENT_MESH_CLIENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "dynmesh/client/diff_stream.h"
#include "dynmesh/client/edit_session.h"
#include "dynmesh/client/load.h"
#include "dynmesh/client/watch_session.h"
#include "dynmesh/codec/features_at.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh::client {

// A mesh as the server tells of it.
struct MeshInfo {
  std::string id;
  MeshOptions options;
  absl::Time create_time;
  std::uint64_t revision = 0;
  MeshHash hash;
  // Why it is damaged. In lists only, with nothing else but the id: the server could not make it
  // again. With all else, and read_only: acknowledged revisions are gone.
  std::string damage;
  bool read_only = false;
};

struct MeshStatus {
  int dimension = 2;
  MeshStats stats;
  MeshHash hash;
  std::uint64_t oldest_revision = 0;  // the earliest a watch may start from
  std::uint64_t watchers = 0;
  std::uint64_t waiting_edits = 0;
};

struct ServerStatus {
  std::string version;
  absl::Duration uptime;
  std::uint64_t meshes = 0;
  std::uint64_t watchers = 0;
  std::optional<MeshStatus> mesh;  // if one was asked for
};

struct Located {
  std::uint64_t revision = 0;
  // dimension + 1 vertex ids for each point, all 0 outside the domain.
  SimplexColumn simplices;
};

struct ClientOptions {
  // For each call that is not a stream of unknown length.
  absl::Duration timeout = absl::InfiniteDuration();
  // A connection of its own, not shared with other clients of this process.
  bool own_connection = false;

  // TLS, as PEM texts: who signed the server's certificate, and what the client shows if the
  // server asks it to. All empty: no encryption.
  std::string tls_ca;
  std::string tls_certificate;
  std::string tls_key;
  // Shown with every call. Without TLS whoever is on the way can read it.
  std::string token;

  bool tls() const { return !tls_ca.empty() || !tls_certificate.empty(); }
};

class MeshClient {
 public:
  // Never fails: the first call tells whether the server is there.
  static std::unique_ptr<MeshClient> Connect(const std::string& address,
                                             const ClientOptions& options = {});
  ~MeshClient();

  // An empty id lets the server choose. limits.max_vertices at its default takes the
  // server's limit.
  absl::StatusOr<MeshInfo> CreateMesh(const std::string& id, const MeshOptions& options,
                                      const std::string& request_id = "");
  absl::StatusOr<MeshInfo> GetMesh(const std::string& mesh);
  absl::StatusOr<std::vector<MeshInfo>> ListMeshes();
  absl::Status DeleteMesh(const std::string& mesh);

  // One atomic batch. Batches too large for a message go in pieces. Of a mesh of space,
  // params.dimension must be 3.
  absl::StatusOr<EditResult> Apply(const std::string& mesh, const EditBatch& edits,
                                   const EditParams& params = {});
  absl::StatusOr<EditResult> AddFeatures(const std::string& mesh, std::span<const Feature> features,
                                         const EditParams& params = {});
  absl::StatusOr<EditResult> RemoveFeatures(const std::string& mesh, std::span<const FeatureId> ids,
                                            const EditParams& params = {});

  // Adds features, as many as the server lets a batch have, as one atomic batch. An error names
  // the feature to blame; what was sent until then changes nothing.
  absl::StatusOr<LoadResult> Load(const std::string& mesh, const FeatureSource& source,
                                  const LoadParams& params = {});
  absl::StatusOr<LoadResult> Load(const std::string& mesh, std::span<const Feature> features,
                                  const LoadParams& params = {});
  // The features at a revision, by default the present one.
  absl::StatusOr<codec::FeaturesAt> GetFeatures(const std::string& mesh,
                                                std::optional<std::uint64_t> revision = {});
  // Makes a new revision with the features of an earlier one. params.validate_only and dimension
  // are not looked at.
  absl::StatusOr<EditResult> RevertTo(const std::string& mesh, std::uint64_t revision,
                                      const EditParams& params = {});

  // A pipeline of batches. To be opened when there is one: a server does not wait for it for ever.
  std::unique_ptr<EditSession> OpenEdits(const std::string& mesh, bool stop_on_error = false);

  // Follows the mesh in a replica, until the session is destroyed. `listener` may be
  // null; else it outlives the session.
  std::unique_ptr<WatchSession> Watch(const std::string& mesh, const WatchOptions& options,
                                      WatchListener* listener);

  // The revisions of the mesh, for a caller that keeps it itself.
  std::unique_ptr<DiffStream> StreamDiffs(const std::string& mesh,
                                          const DiffStreamOptions& options);

  // With `regions`, ids of polygons: the simplices inside at least one of them, and what
  // these need.
  absl::StatusOr<Mesh> GetSnapshot(const std::string& mesh,
                                   std::span<const FeatureId> regions = {});
  // An empty name asks for the server only.
  absl::StatusOr<ServerStatus> GetStats(const std::string& mesh = "");
  // n x dimension coordinates, any n.
  absl::StatusOr<Located> Locate(const std::string& mesh, int dimension,
                                 std::span<const double> points);

 private:
  struct Impl;
  explicit MeshClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_MESH_CLIENT_H_
