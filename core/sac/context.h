// Engine<Program>::Context: an operation's view of the engine while it runs.
#ifndef DYNMESH_CORE_SAC_CONTEXT_H_
#define DYNMESH_CORE_SAC_CONTEXT_H_

#include <cstdint>
#include <span>

#include "core/sac/engine.h"

namespace dynmesh::sac {

template <class Program>
class Engine<Program>::Context {
 public:
  Context(Engine& engine, OpId id)
      : kind(engine.ops_[id].kind),
        item(engine.ops_[id].item),
        epoch(engine.ops_[id].epoch),
        now(engine.ops_[id].stamp),
        engine_(engine),
        id_(id) {}

  const Kind kind;
  const Item item;
  const Epoch epoch;
  const Stamp now;

  // True if an object born at time `birth` exists as of this operation.
  bool Sees(Stamp birth) const { return engine_.Precedes(birth, now); }

  void Emit(Output output) { engine_.made_.outputs.push_back(output); }
  void Request(Kind k, Item i, Epoch e) { engine_.made_.requests.push_back({i, e, k}); }
  void Subscribe(Place place, Parts parts = kAllParts) {
    engine_.made_.subscriptions.push_back({place, parts});
  }
  void Read(std::uint32_t word) { engine_.made_.reads.push_back(word); }

  // The outputs and reads of the previous execution; both are empty the first time. Emitting an old
  // word keeps that output; else the program makes a new object.
  std::span<const Output> old_outputs() const { return engine_.outputs(id_); }
  std::span<const std::uint32_t> old_reads() const { return engine_.reads(id_); }
  typename PayloadOf<Program>::Type& payload() { return engine_.ops_[id_].payload; }
  bool first_time() const { return !engine_.executed(id_); }
  OpId id() const { return id_; }

 private:
  Engine& engine_;
  OpId id_;
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_CONTEXT_H_
