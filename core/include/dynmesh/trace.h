// The trace of a mesh as plain data: the operations of the run that made it, what each of them
// read, made and requested, and what the last batch did to them. It shows how an edit is propagated
// (docs/engine.md); meshing does not use it.
//
//   auto trace = dynmesh::TraceOf(features, batch, options);   // check trace.ok()
//   for (const dynmesh::TraceOperation& operation : trace->operations) {
//     if (operation.fate == dynmesh::TraceOperation::Fate::kRerun) Show(operation);
//   }
#ifndef DYNMESH_TRACE_H_
#define DYNMESH_TRACE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"
#include "dynmesh/options.h"

namespace dynmesh {

// A vertex that occurs in a trace. An operation that runs again may make a vertex at the same
// position with other properties: that is another one.
struct TraceVertex {
  VertexId id = 0;                      // VertexIdAt, with salt 0
  std::array<double, 3> position = {};  // in 2D the last coordinate is 0
  bool is_input = false;                // of a feature, the box or a target length: none made it
  friend bool operator==(const TraceVertex&, const TraceVertex&) = default;
};

// A cell of the tree of vertices: a place that operations subscribe to.
struct TraceCell {
  std::array<double, 3> centre = {};  // in 2D the last coordinate is 0
  double side = 0;                    // its length
  friend bool operator==(const TraceCell&, const TraceCell&) = default;
};

// What an operation makes.
struct TraceOutput {
  // What the output is, or does.
  enum class What : std::uint8_t {
    kVertex,      // a new vertex
    kSubsegment,  // a new subsegment
    kExposure,    // the subsegment is visible to later operations
    kDeath,       // the subsegment is split: later operations do not see it any more
  };
  What what = What::kVertex;               // of these
  std::array<std::uint32_t, 2> ends = {};  // in Trace::vertices: twice the vertex, or the ends
  friend bool operator==(const TraceOutput&, const TraceOutput&) = default;
};

// An operation: a procedure, what it works on, and when.
struct TraceOperation {
  // What the last batch did to it.
  enum class Fate : std::uint8_t {
    kKept,     // it did not run again
    kRerun,    // it was there before and ran again
    kAdded,    // it is new
    kRemoved,  // it is gone: nothing requests it any more
  };
  std::string_view procedure = {};  // Nearest, Complete, Check, Split, Recheck, Presplit or Cure
  // Its time: all work of a bucket comes before that of the next one, and so do rounds within the
  // bucket, and steps within the round. The last step of a round is its quality work.
  std::uint32_t bucket = 0;              // of edge lengths; bucket 0 is the input's
  std::uint64_t round = 0;               // within the bucket
  std::optional<std::uint64_t> step;     // within the round; none: the quality work
  std::vector<std::uint32_t> item;       // vertices: one, the ends of a subsegment, or four corners
  std::vector<TraceOutput> made;         // now; of a removed one, before
  std::vector<TraceOutput> made_before;  // of one that ran again: what it made before
  std::vector<std::uint32_t> reads;      // vertices that it depends on
  std::vector<std::uint32_t> cells;      // in Trace::cells: where it depends on what comes and goes
  std::vector<std::uint32_t> requests;   // operations that exist because of it
  Fate fate = Fate::kKept;               // in the last batch
  // Of one that ran again: the operation with a change that it had read. None: that change is of
  // the input, or of the mesh's slivers (min_dihedral).
  std::optional<std::uint32_t> because;
};

// A trace. Indices are of these lists.
struct Trace {
  int dimension = 2;                       // 2 or 3
  std::vector<TraceVertex> vertices;       // in the order in which operations name them
  std::vector<TraceCell> cells;            // the same
  std::vector<TraceOperation> operations;  // in the order of time, removed ones among them

  // How many operations have that fate. O(operations).
  std::size_t Count(TraceOperation::Fate fate) const;
};

// How a trace is taken.
struct TraceOptions {
  // The most operations that the trace may have, before the batch and after it; else
  // RESOURCE_EXHAUSTED (WORK_LIMIT).
  std::uint64_t max_operations = 10'000;
  std::function<bool()> interrupted = nullptr;  // as in ApplyOptions: true gives up (CANCELLED)
};

// The trace of the mesh of `features` after `batch`, and what the batch changed in that of
// `features`. The batch is always propagated, even where DynamicMesh::Apply would build anew: both
// give the same trace. The result is a function of `features`, `batch` and `options`.
//
// Errors: those of DynamicMesh::Create and Apply; INVALID_ARGUMENT (BAD_OPTION) for a quadtree;
// those of `trace_options`. Expected time: that of a mesh of `features`, and O(operations) for each
// operation that the batch runs.
absl::StatusOr<Trace> TraceOf(std::span<const Feature> features, const EditBatch& batch,
                              const MeshOptions& options, const TraceOptions& trace_options = {});

}  // namespace dynmesh

#endif  // DYNMESH_TRACE_H_
