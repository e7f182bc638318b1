// A load: many features, one atomic batch, with progress. For MeshClient::Load.
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

// How far a load is.
struct LoadProgress {
  // What a load goes through, in this order.
  enum class Stage : std::uint8_t {
    kSend,      // features that the server has received; the client knows no total of a source
    kWait,      // for the batches ahead
    kValidate,  // as ApplyProgress::Stage
    kRefine,    // as ApplyProgress::Stage
    kDiff,      // as ApplyProgress::Stage
    kWrite,     // to the server's disk
  };
  Stage stage = Stage::kSend;  // the one that is under way
  std::uint64_t done = 0;      // how much of it is
  std::uint64_t total = 0;     // 0: not known
};

// What is said with a load.
struct LoadParams {
  // Makes a retry safe, as EditParams::request_id.
  std::string request_id;
  // As EditParams::expected_revision.
  std::optional<std::uint64_t> expected_revision;
  int dimension = 2;  // that of the mesh
  // Called about twice a second, from another thread, not after Load has returned. May be null.
  std::function<void(const LoadProgress&)> progress;
  // Asked between pieces and answers; when it turns true the load is cancelled and changes nothing,
  // unless it has been applied already. May be null.
  const std::atomic<bool>* cancelled = nullptr;
};

// What a load did.
struct LoadResult {
  std::uint64_t from_revision = 0;  // before it
  std::uint64_t to_revision = 0;    // after it
  MeshHash hash;                    // at to_revision
  WorkCounters work;                // what it cost
  bool replayed = false;            // a retry: it had been applied before
};

// The features, some at a time, until there are none. What it returns stays until it is called
// again. Called by Load, on its thread.
using FeatureSource = std::function<std::span<const Feature>()>;

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_LOAD_H_
