#include "core/meshing/trace_audit.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <span>

#include "core/meshing/cure.h"
#include "core/meshing/star.h"
#include "core/meshing/star_reads.h"
#include "core/sac/engine_audit.h"

namespace dynmesh::meshing {
namespace {

// The corners, each beginning with its least neighbour (3D), sorted. If corners were not kept, the
// neighbours.
template <int D>
std::vector<std::array<std::uint32_t, D>> StarIn(std::span<const std::uint32_t> words) {
  std::vector<std::array<std::uint32_t, D>> star;
  const bool has_corners = ForEachCornerIn<D>(words, [&](auto ids) {
    if (D == 3) std::rotate(ids.begin(), std::ranges::min_element(ids), ids.end());
    star.push_back(ids);
    return true;
  });
  if (!has_corners) {
    for (const std::uint32_t id : NeighboursIn<D>(words)) star.push_back({id});
  }
  std::ranges::sort(star);
  return star;
}

}  // namespace

std::string_view NameOf(Procedure procedure) {
  constexpr std::string_view kNames[] = {"Nearest", "Complete", "Check", "Split",
                                         "Recheck", "Presplit", "Cure"};
  return kNames[procedure];
}

template <int D>
std::vector<VertexIndex> VerticesReadBy(const Refinement<D, sac::Engine>& refinement,
                                        sac::OpId op) {
  const auto& engine = refinement.engine();
  const auto words = engine.reads(op);
  if (engine.kind(op) == kComplete) {
    const auto ring = NeighboursIn<D>(words);
    return {ring.begin(), ring.end()};
  }
  std::vector<VertexIndex> vertices;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool is_ordinal = engine.kind(op) == kCure && i % 4 == 0;
    if (!is_ordinal) vertices.push_back(words[i]);
  }
  return vertices;
}

template <int D, template <class> class E>
std::uint64_t Audit(const Refinement<D, E>& refinement, std::vector<std::string>* problems,
                    std::vector<OperationHash>* operations) {
  if constexpr (!kIsTraced<D, E>) {
    return 0;
  } else {
    const auto& engine = refinement.engine();
    const auto mix = [](std::uint64_t h, std::uint64_t x) { return Mix(h ^ x); };
    const auto hash_item = [&](sac::Kind kind, sac::Item item) {
      return mix(refinement.Priority(kind, item), kind);
    };
    const auto hash_vertex = [&](std::uint32_t id) {
      if (Star<D>::IsGhost(id)) return static_cast<std::uint64_t>(id);
      const Vertex<D>& v = refinement.vertex(id);
      return mix(geometry::HashOf(v.p), v.epoch);
    };
    std::uint64_t made = 0;
    const auto hash_op = [&](sac::OpId op) {
      const Payload<D>& payload = engine.payload(op);
      // The payload and the reads of a Cure are not hashed: which of several reasons refused a
      // candidate is not determined.
      std::uint64_t h = 0;
      if (engine.kind(op) != kCure) {
        h = mix(std::bit_cast<std::uint32_t>(payload.radius2), payload.flag);
        h = mix(h, payload.cover());
      }
      std::uint64_t sum = 0;
      for (const sac::Output o : engine.outputs(op)) {
        const std::uint32_t i = IndexOf(o);
        if (WhatOf(o) == Made::kVertex) {
          const Vertex<D>& v = refinement.vertex(i);
          ++made;
          if (!v.present) problems->push_back("an operation's vertex is not present");
          if (v.birth != engine.stamp(op)) problems->push_back("a vertex's birth is another's");
          sum += mix(hash_vertex(i), v.ordinal + 256u * v.dimension);
        } else {
          sum += mix(refinement.complex().HashOf(refinement.subsegment(i)), o & 3);
        }
      }
      h = mix(h, sum);
      if (engine.kind(op) != kComplete) return h;  // which witnesses were read is not determined
      // The sum over the corners. It does not depend on the neighbour with which a corner begins.
      std::uint64_t corners = 0;
      ForEachCornerIn<D>(engine.reads(op), [&](const auto& ids) {
        for (int k = 0; k < (D == 2 ? 1 : D); ++k) {
          std::uint64_t turned = 0;
          for (int j = 0; j < D; ++j) turned = mix(turned, hash_vertex(ids[(k + j) % D]) * 3);
          corners += turned;
        }
        return true;
      });
      for (const std::uint32_t id : NeighboursIn<D>(engine.reads(op))) {
        if (!Star<D>::IsGhost(id) && !refinement.vertex(id).present) {
          problems->push_back("an operation has read a vertex that is gone");
        }
      }
      return mix(h, corners);
    };
    const auto on_op = [&](sac::OpId op, std::uint64_t whole) {
      if (operations == nullptr) return;
      const std::uint64_t item = hash_item(engine.kind(op), engine.item(op));
      operations->push_back({mix(item, engine.epoch(op)), whole, op});
    };
    const std::uint64_t hash = engine.Audit(hash_item, hash_op, on_op, problems);
    std::size_t present = 0, inputs = 0;
    refinement.elements().ForEachVertex([&](VertexIndex, const Vertex<D>& v) {
      ++present;
      inputs += v.creator == sac::kNoOp;
    });
    if (present != refinement.elements().vertex_count())
      problems->push_back("vertices present are not those counted");
    if (present != made + inputs) problems->push_back("a vertex is present that no operation made");
    return hash;
  }
}

template <int D>
bool Reproduces(Refinement<D, sac::Engine>& refinement, sac::OpId op, std::string* why) {
  auto& engine = refinement.engine();
  const auto is_there = [&](VertexIndex v) {
    return Star<D>::IsGhost(v) || (refinement.vertex(v).present &&
                                   engine.Precedes(refinement.vertex(v).birth, engine.stamp(op)));
  };
  const auto same = [&](sac::OpId id, const Payload<D>& payload,
                        std::span<const std::uint32_t> reads) {
    if (!std::ranges::all_of(VerticesReadBy<D>(refinement, id), is_there)) return false;
    const Payload<D>& kept = engine.payload(id);
    if (engine.kind(id) == kCure) return true;
    if (kept.radius2 != payload.radius2 || kept.flag != payload.flag ||
        kept.cover() != payload.cover()) {
      return false;
    }
    return engine.kind(id) != kComplete || StarIn<D>(engine.reads(id)) == StarIn<D>(reads);
  };
  return engine.Reproduces(op, same, why);
}

template <int D>
std::string FirstUnreproduced(Refinement<D, sac::Engine>& refinement) {
  std::vector<std::string> problems;
  std::vector<OperationHash> operations;
  Audit(refinement, &problems, &operations);
  if (!problems.empty()) return problems.front();
  std::string why;
  for (const OperationHash& operation : operations) {
    if (Reproduces(refinement, operation.op, &why)) continue;
    return "other " + why + " when run again: " + Describe(refinement, operation.op);
  }
  return "";
}

template <int D, template <class> class E>
std::string Describe(const Refinement<D, E>& refinement, sac::OpId op) {
  std::string text;
  if constexpr (kIsTraced<D, E>) {
    const auto& engine = refinement.engine();
    const auto add = [&text](const auto&... parts) { (text.append(parts), ...); };
    const auto add_vertex = [&](VertexIndex v) {
      if (Star<D>::IsGhost(v)) return add(" ghost");
      for (int k = 0; k < D; ++k) {
        char number[32];
        std::snprintf(number, sizeof(number), "%.17g", refinement.vertex(v).p[k]);
        add(k == 0 ? " (" : ", ", number);
      }
      add(")");
    };
    const sac::Kind kind = engine.kind(op);
    const sac::Item item = engine.item(op);
    add(NameOf(static_cast<Procedure>(kind)), " of");
    if (kind <= kComplete) {
      add_vertex(item);
    } else if (kind == kCure) {
      for (const VertexIndex v : refinement.complex().slivers[item].v) add_vertex(v);
    } else {
      add_vertex(refinement.subsegment(item).a);
      add_vertex(refinement.subsegment(item).b);
    }
    const sac::Epoch epoch = engine.epoch(op);
    add(", bucket ", std::to_string(BucketOfEpoch(epoch)), ", round ",
        std::to_string(RoundOfEpoch(epoch)), ", step ", std::to_string(StepOfEpoch(epoch)),
        ", made:");
    for (const sac::Output o : engine.outputs(op)) {
      if (WhatOf(o) == Made::kVertex) {
        add_vertex(IndexOf(o));
      } else {
        const Subsegment<D>& s = refinement.subsegment(IndexOf(o));
        add(" subsegment");
        add_vertex(s.a), add_vertex(s.b);
      }
    }
    if (kind == kComplete) {
      add(", read:");
      for (const std::uint32_t v : NeighboursIn<D>(engine.reads(op))) add_vertex(v);
    } else {
      add(", words read: ", std::to_string(engine.reads(op).size()));
    }
  }
  return text;
}

template std::uint64_t Audit(const Refinement<2, sac::Engine>&, std::vector<std::string>*,
                             std::vector<OperationHash>*);
template std::string Describe(const Refinement<2, sac::Engine>&, sac::OpId);
template bool Reproduces(Refinement<2, sac::Engine>&, sac::OpId, std::string*);
template std::string FirstUnreproduced(Refinement<2, sac::Engine>&);
template std::vector<VertexIndex> VerticesReadBy(const Refinement<2, sac::Engine>&, sac::OpId);
template std::uint64_t Audit(const Refinement<2, sac::UntracedEngine>&, std::vector<std::string>*,
                             std::vector<OperationHash>*);
template std::string Describe(const Refinement<2, sac::UntracedEngine>&, sac::OpId);
template std::uint64_t Audit(const Refinement<3, sac::Engine>&, std::vector<std::string>*,
                             std::vector<OperationHash>*);
template std::string Describe(const Refinement<3, sac::Engine>&, sac::OpId);
template bool Reproduces(Refinement<3, sac::Engine>&, sac::OpId, std::string*);
template std::string FirstUnreproduced(Refinement<3, sac::Engine>&);
template std::vector<VertexIndex> VerticesReadBy(const Refinement<3, sac::Engine>&, sac::OpId);
template std::uint64_t Audit(const Refinement<3, sac::UntracedEngine>&, std::vector<std::string>*,
                             std::vector<OperationHash>*);
template std::string Describe(const Refinement<3, sac::UntracedEngine>&, sac::OpId);

}  // namespace dynmesh::meshing
