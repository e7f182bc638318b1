// The client library: a server's meshes as typed calls.
//
//   auto client = MeshClient::Connect("127.0.0.1:7878");
//   auto mesh = client->CreateMesh("plate", options);
//   auto result = client->Apply("plate", {Edit::Add(Feature::Point(1, 0.5, 0.5))});
//   auto replica = client->Watch("plate", {}, nullptr);   // follows the mesh
//
// Errors are absl::Status with a machine-readable detail: codec::GetServiceError(status) has
// reason, features, field and retry_after (dynmesh/codec/service_error.h). Meshes are named by id
// ("plate") or by resource name ("meshes/plate"). Thread-safe.
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
#include "dynmesh/client/build.h"
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

// A mesh as described by the server.
struct MeshInfo {
  std::string id;              // "plate"
  MeshOptions options;         // as it was created
  absl::Time create_time;      // by the server's clock
  std::uint64_t revision = 0;  // the current one
  MeshHash hash;               // at that revision
  // Why the mesh is damaged; empty: it is not. ListMeshes sets only this and id if the server could
  // not recover the mesh. With read_only all fields are set, and acknowledged revisions are lost.
  std::string damage;
  bool read_only = false;  // the server refuses edits: DATA_LOSS (MESH_DAMAGED)
  // Of ListMeshes, for servers that share their meshes: "HOST:PORT" of another server that has the
  // mesh, or "none". Then only this, id, create_time and revision are set; GetMesh sets all.
  std::string owner;
};

// The state of a mesh of the server.
struct MeshStatus {
  int dimension = 2;                  // 2 or 3
  MeshStats stats;                    // counts and memory
  MeshHash hash;                      // at the current revision
  std::uint64_t oldest_revision = 0;  // the earliest that a watch may start from without a journal
  std::uint64_t watchers = 0;         // open watch streams
  std::uint64_t waiting_edits = 0;    // batches that wait
};

// The state of the server.
struct ServerStatus {
  std::string version;             // "MAJOR.MINOR.PATCH"
  absl::Duration uptime;           // since its start
  std::uint64_t meshes = 0;        // number of meshes
  std::uint64_t watchers = 0;      // open watch streams of all meshes
  std::optional<MeshStatus> mesh;  // if requested
};

// The result of Locate.
struct Located {
  std::uint64_t revision = 0;  // of the mesh that was searched
  // dimension + 1 vertex ids for each point, all 0 outside the domain.
  SimplexColumn simplices;
  std::vector<double> leaf_sides;  // of a quadtree, as DynamicMesh::LeafSides; else empty
};

// How a client connects.
struct ClientOptions {
  // The deadline of each RPC except OpenEdits, Watch and StreamDiffs. ListMeshes, GetFeatures and
  // Locate may make several RPCs.
  absl::Duration timeout = absl::InfiniteDuration();
  // If true, a separate connection; else clients of this process with equal options share one.
  bool own_connection = false;
  // If true, GetSnapshot, GetFeatures, Locate, Watch and StreamDiffs ask the first server that can
  // be reached, which may follow the mesh of another one. Their answers may be some ten
  // milliseconds old, but have at least the revisions that this client has got by Apply,
  // AddFeatures, RemoveFeatures, RevertTo and these reads.
  bool from_followers = false;

  // PEM texts for TLS. All empty: no encryption.

  std::string tls_ca;           // certificates of the server's issuers
  std::string tls_certificate;  // the client's own, for a server that requires one
  std::string tls_key;          // the private key of the client's certificate
  // Sent with every call. Without TLS it is readable on the network.
  std::string token;

  // Is the connection encrypted?
  bool tls() const { return !tls_ca.empty() || !tls_certificate.empty(); }
};

// A server; see mesh_client.h. Errors of every call:
//   * UNAVAILABLE: the server cannot be reached; DRAINING: it stops; RECOVERING: it reads its
//     journal; NOT_OWNER: another server has the mesh, and the client did not get there;
//   * DEADLINE_EXCEEDED: after ClientOptions::timeout;
//   * UNAUTHENTICATED (TOKEN_MISSING, TOKEN_UNKNOWN), PERMISSION_DENIED (ROLE_MISSING);
//   * RESOURCE_EXHAUSTED (RATE_LIMIT): too many requests of this client;
//   * INVALID_ARGUMENT: BAD_NAME, or BAD_REQUEST of a malformed parameter;
//   * NOT_FOUND (MESH_NOT_FOUND, MESH_DELETED), DATA_LOSS (MESH_DAMAGED): of calls on a mesh;
//   * DATA_LOSS without a reason: the answer is incomplete or damaged.
//
// Several servers may share their meshes; each mesh is at one of them at a time. The client goes to
// that one by itself, as NOT_OWNER names it, and repeats the call there. If a server that has
// meshes ends, another one takes them over after some seconds. So, if the client knows several
// servers, it repeats a call that one of them did not answer, or answered with OUTCOME_UNKNOWN, at
// another: reads, and changes with a request_id, some ten seconds long. A call without an answer
// for a second makes it ask another server where the mesh is; if it is no longer at the one that
// was asked, the call is repeated where it is. Apart from that the client never repeats a call. A
// load, and an edit session, are not repeated, but the next one goes to the right server; after
// JOURNAL_FAILED the next call asks another one.
//
// The client reconnects to a server by itself, in a thread of its own, for half a minute after the
// last call that did not reach it. Pauses between attempts are about a third of the time that has
// passed, 0.1 to 5 seconds. If ServiceError::retry_after is set, repeat the call after that time;
// PauseBeforeRetry returns earlier if the server comes back. Changes are safe to repeat with the
// same request_id; reads always are. Watch and StreamDiffs reconnect and resume by themselves.
class MeshClient {
 public:
  // A client of the server at `address` ("host:port"), as `options` say; of servers that share
  // their meshes, some of them with commas between: one that can be reached is enough. Never fails:
  // the first call reports an unreachable server.
  static std::unique_ptr<MeshClient> Connect(const std::string& address,
                                             const ClientOptions& options = {});
  ~MeshClient();

  // Makes a mesh `id` with `options`; with an empty id the server chooses one. If
  // limits.max_vertices has its default, the server's limit applies. `request_id` makes a retry
  // safe. ALREADY_EXISTS (MESH_EXISTS; REQUEST_ID_REUSED: with other `options`); INVALID_ARGUMENT
  // (BAD_OPTION); RESOURCE_EXHAUSTED (MESH_LIMIT, MEMORY_LIMIT, VERTEX_LIMIT); UNAVAILABLE or
  // DATA_LOSS (JOURNAL_FAILED).
  absl::StatusOr<MeshInfo> CreateMesh(const std::string& id, const MeshOptions& options,
                                      const std::string& request_id = "");
  // Describes `mesh`. Errors: those of every call.
  absl::StatusOr<MeshInfo> GetMesh(const std::string& mesh);
  // All meshes that the client may read, by id. Errors: those of every call.
  absl::StatusOr<std::vector<MeshInfo>> ListMeshes();
  // Deletes `mesh` with all its revisions and ends its watches. UNAVAILABLE or DATA_LOSS
  // (JOURNAL_FAILED).
  absl::Status DeleteMesh(const std::string& mesh);

  // Applies `edits` to `mesh` as one atomic batch, as `params` say; in parts if it is too large
  // for one message. In 3D, params.dimension must be 3. On an error nothing is changed, except that
  // after DEADLINE_EXCEEDED, CANCELLED, and UNAVAILABLE without a reason or with OUTCOME_UNKNOWN,
  // the batch may have been applied: repeat it with its request_id. Errors: those of
  // DynamicMesh::Apply and EditParams, and
  //   * INVALID_ARGUMENT: WRONG_DIMENSION, BATCH_TOO_LARGE (more edits than the server allows);
  //   * RESOURCE_EXHAUSTED: FEATURE_LIMIT; QUEUE_FULL, PENDING_LIMIT, MEMORY_LIMIT: retry later;
  //   * UNAVAILABLE or DATA_LOSS: JOURNAL_FAILED, the batch could not be written.
  absl::StatusOr<EditResult> Apply(const std::string& mesh, const EditBatch& edits,
                                   const EditParams& params = {});
  // Applies edits that add `features` to `mesh`; `params` and errors as of Apply.
  absl::StatusOr<EditResult> AddFeatures(const std::string& mesh, std::span<const Feature> features,
                                         const EditParams& params = {});
  // Applies edits that remove the features `ids` of `mesh`; `params` and errors as of Apply.
  absl::StatusOr<EditResult> RemoveFeatures(const std::string& mesh, std::span<const FeatureId> ids,
                                            const EditParams& params = {});

  // Adds the features of `source` to `mesh` as one atomic batch, as large as the server allows;
  // `params` can report its progress and cancel it. An error names the feature to blame, and
  // nothing is changed. Errors as of Apply; CANCELLED by `params`; DEADLINE_EXCEEDED
  // (BATCH_INCOMPLETE) if `source` returns nothing for too long.
  absl::StatusOr<LoadResult> Load(const std::string& mesh, const FeatureSource& source,
                                  const LoadParams& params = {});
  // Adds `features` to `mesh`; `params` and errors as above.
  absl::StatusOr<LoadResult> Load(const std::string& mesh, std::span<const Feature> features,
                                  const LoadParams& params = {});
  // The features of `mesh` at a `revision`, by default the current one. OUT_OF_RANGE (COMPACTED,
  // FUTURE_REVISION) for one that the server does not have; FAILED_PRECONDITION (NO_HISTORY) for an
  // earlier one of a server without a journal; JOURNAL_FAILED if it cannot be read. Calls GetMesh
  // first.
  absl::StatusOr<codec::FeaturesAt> GetFeatures(const std::string& mesh,
                                                std::optional<std::uint64_t> revision = {});
  // Makes a new revision of `mesh` with the features of an earlier `revision`. Ignores
  // `params`.validate_only and dimension. Errors as of GetFeatures and Apply.
  absl::StatusOr<EditResult> RevertTo(const std::string& mesh, std::uint64_t revision,
                                      const EditParams& params = {});

  // Waits before a call that failed with UNAVAILABLE is made again: for `limit`, or until a server
  // that could not be reached can be.
  void PauseBeforeRetry(absl::Duration limit);
  // How often a server that could not be reached could be again. For callers that wait by their own
  // means.
  std::uint64_t servers_returned() const;

  // A pipeline of batches to `mesh`. With `stop_on_error` a refused batch ends it. Open it when
  // there is a batch to send: the server ends a stream without one after some minutes.
  std::unique_ptr<EditSession> OpenEdits(const std::string& mesh, bool stop_on_error = false);

  // Follows `mesh` in a replica, as `options` say, until the session is destroyed. `listener` is
  // null or outlives the session. Errors: WatchSession::ended.
  std::unique_ptr<WatchSession> Watch(const std::string& mesh, const WatchOptions& options,
                                      WatchListener* listener);

  // The revisions of `mesh` from where `options` say, for a caller that keeps the mesh itself.
  // Errors: DiffStream::Next.
  std::unique_ptr<DiffStream> StreamDiffs(const std::string& mesh,
                                          const DiffStreamOptions& options);

  // The whole `mesh` at its current revision. With `regions`, ids of polygons: only the simplices
  // inside at least one of them, with their vertices, subsegments and subfacets. Checks the hash:
  // DATA_LOSS. INVALID_ARGUMENT if `regions` has more than 10,000 ids.
  absl::StatusOr<Mesh> GetSnapshot(const std::string& mesh,
                                   std::span<const FeatureId> regions = {});
  // The state of the server and of `mesh`; an empty name: of the server only. Errors: those of
  // every call.
  absl::StatusOr<ServerStatus> GetStats(const std::string& mesh = "");
  // For each of n `points` (n x `dimension` coordinates, any n) the vertex ids of the simplex of
  // `mesh` that contains it, as DynamicMesh::Locate. The server applies the edits before it first.
  // INVALID_ARGUMENT: `dimension` is not 2 or 3, the number of coordinates is not a multiple of the
  // mesh's, or one is not finite (NOT_FINITE). RESOURCE_EXHAUSTED (QUEUE_FULL). ABORTED: the mesh
  // changed between two RPCs of up to 30,000 points each; repeat the call.
  absl::StatusOr<Located> Locate(const std::string& mesh, int dimension,
                                 std::span<const double> points);

  // Has the server make the mesh of `features` with `options`, as `params` say, and forget it: the
  // mesh that dynmesh::BuildMesh returns. If limits.max_vertices has its default, the server's
  // limit applies. Checks the hash: DATA_LOSS. Errors: those of dynmesh::BuildMesh, which name the
  // feature to blame, and
  //   * INVALID_ARGUMENT: BATCH_TOO_LARGE (more features than the server allows), BAD_REQUEST
  //     (`params`.max_time is negative or above the server's limit);
  //   * RESOURCE_EXHAUSTED: TIME_LIMIT, FEATURE_LIMIT; STREAM_LIMIT, CLIENT_STREAM_LIMIT,
  //     PENDING_LIMIT, MEMORY_LIMIT: retry later;
  //   * CANCELLED by `params`; UNIMPLEMENTED: an older server.
  absl::StatusOr<Mesh> BuildMesh(std::span<const Feature> features, const MeshOptions& options,
                                 const BuildParams& params = {});

 private:
  struct Impl;
  explicit MeshClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_MESH_CLIENT_H_
