// A load: many features as one atomic batch, with progress. For MeshClient::Load.
//
//   dynmesh::client::LoadParams params;
//   params.progress = [](const dynmesh::client::LoadProgress& p) { Show(p.done, p.total); };
//   auto result = client->Load("plate", features, params);
#ifndef DYNMESH_CLIENT_LOAD_H_
#define DYNMESH_CLIENT_LOAD_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::client {

// Progress of a load.
struct LoadProgress {
  // The stages of a load, in this order; some may not be reported.
  enum class Stage : std::uint8_t {
    kSend,      // features received by the server; the client knows no total of a source
    kWait,      // waits for the batches ahead
    kValidate,  // as ApplyProgress::Stage
    kRefine,    // as ApplyProgress::Stage
    kDiff,      // as ApplyProgress::Stage
    kWrite,     // writes to the server's disk
  };
  Stage stage = Stage::kSend;  // the current one
  std::uint64_t done = 0;      // units of it that are done
  std::uint64_t total = 0;     // all its units; 0: not known
};

// Parameters of a load.
struct LoadParams {
  // Makes a retry safe, as EditParams::request_id.
  std::string request_id;
  // As EditParams::expected_revision.
  std::optional<std::uint64_t> expected_revision;
  int dimension = 2;  // the dimension of the mesh
  // Called about twice a second from another thread, never after Load has returned. May be null.
  std::function<void(const LoadProgress&)> progress;
  // Polled between messages in both directions. Once true, the load is cancelled: CANCELLED. It
  // then changes nothing, unless it was applied already. May be null.
  const std::atomic<bool>* cancelled = nullptr;
};

// The result of a load.
struct LoadResult {
  std::uint64_t from_revision = 0;  // before the load
  std::uint64_t to_revision = 0;    // after the load
  MeshHash hash;                    // at to_revision
  WorkCounters work;                // its cost
  bool replayed = false;            // a retry of a load that had been applied
};

// Returns the next features, an empty span at the end. The span must be valid until the next call.
// Load calls it on its own thread.
using FeatureSource = std::function<std::span<const Feature>()>;

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_LOAD_H_
