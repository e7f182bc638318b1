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
  std::string id;              // "plate"
  MeshOptions options;         // as it was created
  absl::Time create_time;      // by the server's clock
  std::uint64_t revision = 0;  // the present one
  MeshHash hash;               // at that revision
  // Why it is damaged. In lists only, with nothing else but the id: the server could not make it
  // again. With all else, and read_only: acknowledged revisions are gone.
  std::string damage;
  bool read_only = false;  // edits are refused
};

// How a mesh of the server is.
struct MeshStatus {
  int dimension = 2;                  // 2 or 3
  MeshStats stats;                    // counts and memory
  MeshHash hash;                      // at the present revision
  std::uint64_t oldest_revision = 0;  // the earliest a watch may start from
  std::uint64_t watchers = 0;         // streams that follow it
  std::uint64_t waiting_edits = 0;    // batches that wait for their turn
};

// How the server is.
struct ServerStatus {
  std::string version;             // "MAJOR.MINOR.PATCH"
  absl::Duration uptime;           // since its start
  std::uint64_t meshes = 0;        // that it has
  std::uint64_t watchers = 0;      // of all meshes
  std::optional<MeshStatus> mesh;  // if one was asked for
};

// Where points lie.
struct Located {
  std::uint64_t revision = 0;  // of the mesh that was looked at
  // dimension + 1 vertex ids for each point, all 0 outside the domain.
  SimplexColumn simplices;
};

// How a client connects.
struct ClientOptions {
  // For each call that is not a stream of unknown length.
  absl::Duration timeout = absl::InfiniteDuration();
  // A connection of its own, not shared with other clients of this process.
  bool own_connection = false;

  // TLS is described by PEM texts. All empty: no encryption.

  std::string tls_ca;           // certificates that sign the server's
  std::string tls_certificate;  // the client's own, for a server that asks for one
  std::string tls_key;          // of the client's certificate
  // Sent with every call. Without TLS it can be read on the way.
  std::string token;

  // Is the connection encrypted?
  bool tls() const { return !tls_ca.empty() || !tls_certificate.empty(); }
};

// A server; see mesh_client.h. Calls return UNAVAILABLE while it cannot be reached, and
// DEADLINE_EXCEEDED after ClientOptions::timeout.
class MeshClient {
 public:
  // A client of the server at `address` ("host:port"), as `options` say. Never fails: the first
  // call tells whether the server is there.
  static std::unique_ptr<MeshClient> Connect(const std::string& address,
                                             const ClientOptions& options = {});
  ~MeshClient();

  // Makes a mesh `id` with `options`; an empty id lets the server choose. limits.max_vertices at
  // its default takes the server's limit. `request_id` makes a retry safe. ALREADY_EXISTS
  // (MESH_EXISTS).
  absl::StatusOr<MeshInfo> CreateMesh(const std::string& id, const MeshOptions& options,
                                      const std::string& request_id = "");
  // What the server tells of `mesh`; NOT_FOUND (MESH_NOT_FOUND).
  absl::StatusOr<MeshInfo> GetMesh(const std::string& mesh);
  // All meshes that the client may read, by id.
  absl::StatusOr<std::vector<MeshInfo>> ListMeshes();
  // Deletes `mesh` with all its revisions, and ends its watches.
  absl::Status DeleteMesh(const std::string& mesh);

  // Applies `edits` to `mesh` as one atomic batch, as `params` say. Batches too large for a message
  // go in pieces. Of a mesh of space, params.dimension must be 3.
  absl::StatusOr<EditResult> Apply(const std::string& mesh, const EditBatch& edits,
                                   const EditParams& params = {});
  // The same with edits that add `features` to `mesh`; `params` as of Apply.
  absl::StatusOr<EditResult> AddFeatures(const std::string& mesh, std::span<const Feature> features,
                                         const EditParams& params = {});
  // The same with edits that remove the features `ids` of `mesh`; `params` as of Apply.
  absl::StatusOr<EditResult> RemoveFeatures(const std::string& mesh, std::span<const FeatureId> ids,
                                            const EditParams& params = {});

  // Adds the features of `source` to `mesh`, as many as the server lets a batch have, as one atomic
  // batch; `params` can follow and cancel it. An error names the feature to blame; what was sent
  // until then changes nothing.
  absl::StatusOr<LoadResult> Load(const std::string& mesh, const FeatureSource& source,
                                  const LoadParams& params = {});
  // The same with `features` to add to `mesh`; `params` as above.
  absl::StatusOr<LoadResult> Load(const std::string& mesh, std::span<const Feature> features,
                                  const LoadParams& params = {});
  // The features of `mesh` at a `revision`, by default the present one. OUT_OF_RANGE for one that
  // the server does not have.
  absl::StatusOr<codec::FeaturesAt> GetFeatures(const std::string& mesh,
                                                std::optional<std::uint64_t> revision = {});
  // Makes a new revision of `mesh` with the features of an earlier `revision`.
  // `params`.validate_only and dimension are not looked at.
  absl::StatusOr<EditResult> RevertTo(const std::string& mesh, std::uint64_t revision,
                                      const EditParams& params = {});

  // A pipeline of batches to `mesh`. With `stop_on_error` a batch that is refused ends it. To be
  // opened when there is a batch: a server does not wait for it for ever.
  std::unique_ptr<EditSession> OpenEdits(const std::string& mesh, bool stop_on_error = false);

  // Follows `mesh` in a replica, as `options` say, until the session is destroyed. `listener` may
  // be null; else it outlives the session.
  std::unique_ptr<WatchSession> Watch(const std::string& mesh, const WatchOptions& options,
                                      WatchListener* listener);

  // The revisions of `mesh` from where `options` say, for a caller that keeps it itself.
  std::unique_ptr<DiffStream> StreamDiffs(const std::string& mesh,
                                          const DiffStreamOptions& options);

  // The present `mesh`, whole. With `regions`, ids of polygons: the simplices inside at least one
  // of them, and what these need.
  absl::StatusOr<Mesh> GetSnapshot(const std::string& mesh,
                                   std::span<const FeatureId> regions = {});
  // How the server and `mesh` are; an empty name asks for the server only.
  absl::StatusOr<ServerStatus> GetStats(const std::string& mesh = "");
  // For each of n `points` (n x `dimension` coordinates, any n) a simplex of `mesh` that holds it.
  absl::StatusOr<Located> Locate(const std::string& mesh, int dimension,
                                 std::span<const double> points);

 private:
  struct Impl;
  explicit MeshClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_MESH_CLIENT_H_
