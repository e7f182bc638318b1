// TraceOf: takes the trace of a mesh before and after a batch, and compares the two.
#include "dynmesh/trace.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/text.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/live_mesh.h"
#include "core/dynamic_mesh/meshed_features.h"
#include "core/meshing/star.h"
#include "core/meshing/trace_audit.h"
#include "core/plc/messages.h"
#include "core/sac/propagation_log.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

// An operation as of one revision, with the engine's numbers. These stay while nothing is released:
// until the changes of a propagation are taken.
struct Taken {
  sac::OpId op;
  sac::Epoch epoch;
  TraceOperation operation;  // but for `requests` and `because`
  std::vector<sac::OpId> requests;
};

template <int D>
class Tracer {
 public:
  using Refinement = typename MeshState<D>::Refinement;

  Tracer(Trace& trace, const Refinement& refinement) : trace_(trace), refinement_(refinement) {}

  // All operations present, in the order of time. REQUIRES: nothing waits.
  std::vector<Taken> Take() {
    FindCells();
    std::vector<std::string> problems;
    std::vector<meshing::OperationHash> hashes;
    meshing::Audit(refinement_, &problems, &hashes);
    std::vector<Taken> taken;
    for (const meshing::OperationHash& hash : hashes) taken.push_back(Describe(hash.op));
    return taken;
  }

 private:
  // The cells of the tree as it is now, by place. A place may become another cell later.
  void FindCells() {
    place_cells_.clear();
    geometry::Point<D> centre;
    double half = 0;
    meshing::Extent<D> all;
    all.lo.fill(-INFINITY);
    all.hi.fill(INFINITY);
    refinement_.complex().tree.VisitBoxIf(
        all,
        [&](const geometry::Point<D>& c, double h) {
          centre = c;
          half = h;
          return true;
        },
        [&](sac::Place place) {
          place_cells_[place] = {Widened(centre), 2 * half};
        });
  }

  Taken Describe(sac::OpId op) {
    const auto& engine = refinement_.engine();
    const auto kind = static_cast<meshing::Procedure>(engine.kind(op));
    const sac::Epoch epoch = engine.epoch(op);
    Taken taken{op, epoch, {}, {engine.requests(op).begin(), engine.requests(op).end()}};
    TraceOperation& operation = taken.operation;
    operation.procedure = meshing::NameOf(kind);
    operation.bucket = static_cast<std::uint32_t>(meshing::BucketOfEpoch(epoch));
    operation.round = meshing::RoundOfEpoch(epoch);
    if (!meshing::IsQualityEpoch(epoch)) operation.step = meshing::StepOfEpoch(epoch);
    operation.item = ItemOf(kind, engine.item(op));
    for (const sac::Output output : engine.outputs(op)) operation.made.push_back(OutputOf(output));
    for (const meshing::VertexIndex v : meshing::VerticesReadBy<D>(refinement_, op)) {
      if (!meshing::Star<D>::IsGhost(v)) operation.reads.push_back(VertexOf(v));
    }
    for (const sac::Place place : engine.places(op)) operation.cells.push_back(CellOf(place));
    return taken;
  }

  std::vector<std::uint32_t> ItemOf(meshing::Procedure kind, sac::Item item) {
    if (kind <= meshing::kComplete) return {VertexOf(item)};
    if (kind == meshing::kCure) {
      std::vector<std::uint32_t> corners;
      for (const auto v : refinement_.complex().slivers[item].v) corners.push_back(VertexOf(v));
      return corners;
    }
    const auto& s = refinement_.subsegment(item);
    return {VertexOf(s.a), VertexOf(s.b)};
  }

  TraceOutput OutputOf(sac::Output output) {
    using What = TraceOutput::What;
    const std::uint32_t i = meshing::IndexOf(output);
    const meshing::Made what = meshing::WhatOf(output);
    if (what == meshing::Made::kVertex) return {What::kVertex, {VertexOf(i), VertexOf(i)}};
    const auto& s = refinement_.subsegment(i);
    return {what == meshing::Made::kSubsegment ? What::kSubsegment
            : what == meshing::Made::kExposure ? What::kExposure
                                               : What::kDeath,
            {VertexOf(s.a), VertexOf(s.b)}};
  }

  static std::array<double, 3> Widened(const geometry::Point<D>& p) {
    std::array<double, 3> position = {};
    std::copy(p.c.begin(), p.c.end(), position.begin());
    return position;
  }
  std::uint32_t VertexOf(meshing::VertexIndex v) {
    const auto [it, is_new] = vertices_.try_emplace(v, trace_.vertices.size());
    if (is_new) {
      const auto& vertex = refinement_.vertex(v);
      trace_.vertices.push_back(
          {VertexIdAt(vertex.p.c.data(), D), Widened(vertex.p), vertex.creator == sac::kNoOp});
    }
    return it->second;
  }
  std::uint32_t CellOf(sac::Place place) {
    const TraceCell& cell = place_cells_.at(place);
    const auto [it, is_new] = cells_.try_emplace({cell.centre, cell.side}, trace_.cells.size());
    if (is_new) trace_.cells.push_back(cell);
    return it->second;
  }

  Trace& trace_;
  const Refinement& refinement_;
  absl::flat_hash_map<meshing::VertexIndex, std::uint32_t> vertices_;
  absl::flat_hash_map<sac::Place, TraceCell> place_cells_;
  absl::flat_hash_map<std::pair<std::array<double, 3>, double>, std::uint32_t> cells_;
};

// What was there before and what is there now, in one list in the order of time.
class Comparison {
 public:
  Comparison(std::vector<Taken> before, std::vector<Taken> after) {
    absl::flat_hash_map<sac::OpId, std::size_t> is_there, was_there;
    for (std::size_t i = 0; i < after.size(); ++i) is_there[after[i].op] = i;
    for (std::size_t i = 0; i < before.size(); ++i) was_there[before[i].op] = i;
    std::size_t next = 0;
    const auto add_until = [&](std::size_t end) {
      for (; next < end; ++next) {
        const auto was = was_there.find(after[next].op);
        if (was == was_there.end())
          after[next].operation.fate = Fate::kAdded;
        else
          after[next].operation.made_before = std::move(before[was->second].operation.made);
        Add(std::move(after[next]));
      }
    };
    for (Taken& taken : before) {
      const auto is = is_there.find(taken.op);
      if (is != is_there.end()) {
        add_until(is->second + 1);
        continue;
      }
      while (next < after.size() && !was_there.contains(after[next].op) &&
             after[next].epoch < taken.epoch) {
        add_until(next + 1);
      }
      taken.operation.fate = Fate::kRemoved;
      Add(std::move(taken));
    }
    add_until(after.size());
  }

  // Tells which operations ran again, and fills in what names operations.
  std::vector<TraceOperation> Finish(const std::vector<sac::MadeStale>& made_stale) {
    absl::flat_hash_map<sac::OpId, std::uint32_t> index;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      index[all_[i].op] = static_cast<std::uint32_t>(i);
    }
    for (const auto& [op, by] : made_stale) {
      TraceOperation& operation = all_[index.at(op)].operation;
      if (operation.fate != Fate::kKept) continue;  // removed before it ran
      operation.fate = Fate::kRerun;
      if (by != sac::kNoOp) operation.because = index.at(by);
    }
    std::vector<TraceOperation> operations;
    for (Taken& taken : all_) {
      for (const sac::OpId op : taken.requests) {
        taken.operation.requests.push_back(index.at(op));
      }
      if (taken.operation.fate != Fate::kRerun) taken.operation.made_before.clear();
      operations.push_back(std::move(taken.operation));
    }
    return operations;
  }

 private:
  using Fate = TraceOperation::Fate;

  void Add(Taken taken) { all_.push_back(std::move(taken)); }

  std::vector<Taken> all_;
};

absl::Status TooLargeError(std::uint64_t most) {
  return MakeError(absl::StatusCode::kResourceExhausted,
                   text::Concat("the trace has more than ", most,
                                " operations; take that of a smaller scene, or allow more"),
                   {reason::kWorkLimit, {}, {}});
}

template <int D>
class TraceRun {
 public:
  TraceRun(const MeshOptions& options, const TraceOptions& trace_options)
      : options_(options),
        trace_options_(trace_options),
        plc_(options),
        state_(std::make_unique<MeshState<D>>(options, LiveMeshTuning())) {}

  absl::StatusOr<Trace> Run(std::span<const Feature> features, const EditBatch& batch) {
    const auto never = [](std::size_t) { return false; };
    const auto first = plc_.Check(plc::Edits::Adding(features), nullptr, never);
    if (!first.ok()) return first.status();
    state_->features.Apply(*first, state_->refinement);
    if (absl::Status s = Propagate([] {}); !s.ok()) return s;
    state_->refinement.DetachTriangulation();
    state_->diffs.Begin(state_->refinement, state_->features);
    state_->features.Collect();
    plc_.Apply(*first);

    const auto last = plc_.Check(plc::Edits(batch), nullptr, never);
    if (!last.ok()) return last.status();
    Trace trace;
    trace.dimension = D;
    Tracer<D> tracer(trace, state_->refinement);
    std::vector<Taken> before = tracer.Take();
    sac::PropagationLog log(state_->refinement.engine());
    state_->features.Apply(*last, state_->refinement);
    if (absl::Status s = Propagate([&log] { log.Look(); }); !s.ok()) return s;
    log.Look();
    trace.operations = Comparison(std::move(before), tracer.Take()).Finish(log.made_stale());
    return trace;
  }

 private:
  template <class Step>
  absl::Status Propagate(Step step) {
    auto& refinement = state_->refinement;
    const std::uint64_t most = trace_options_.max_operations;
    const auto count = [&] { return refinement.engine().operation_count(); };
    bool is_interrupted = false;
    // On the way both old and new operations are there.
    const bool done = refinement.Propagate([&] {
      step();
      is_interrupted = trace_options_.interrupted != nullptr && trace_options_.interrupted();
      return is_interrupted || count() > 2 * most ||
             IsOverLimits(refinement, options_.limits.max_vertices);
    });
    if (is_interrupted) return GivenUpError();
    if (absl::Status status = LimitsStatus(refinement, options_); !status.ok()) return status;
    if (!done || count() > most) return TooLargeError(most);
    refinement.engine().ResetCounters();
    return absl::OkStatus();
  }

  const MeshOptions& options_;
  const TraceOptions& trace_options_;
  plc::Plc<D> plc_;
  std::unique_ptr<MeshState<D>> state_;
};

}  // namespace

std::size_t Trace::Count(TraceOperation::Fate fate) const {
  return static_cast<std::size_t>(std::ranges::count(operations, fate, &TraceOperation::fate));
}

absl::StatusOr<Trace> TraceOf(std::span<const Feature> features, const EditBatch& batch,
                              const MeshOptions& options, const TraceOptions& trace_options) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  if (options.kind != MeshKind::kDelaunay) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     "kind: a trace is taken of Delaunay meshes only; choose kind delaunay",
                     {reason::kBadOption, {}, {}});
  }
  if (absl::Status status = plc::CheckMaxEdge(options); !status.ok()) return status;
  return options.dimension == 2 ? TraceRun<2>(options, trace_options).Run(features, batch)
                                : TraceRun<3>(options, trace_options).Run(features, batch);
}

}  // namespace dynmesh
