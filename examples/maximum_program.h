// The greatest of many values, kept while values come, change and go: a small program for the
// self-adjusting engine. docs/engine.md says how to write one; the numbers in brackets are those of
// its rules.
//
// The values are the leaves of a binary tree. An inner node has the greater of its children's
// values, so the root has the greatest of all. An operation computes one node. After a change the
// engine runs the nodes on the way to the root again, as far as their values change.
//
// Nodes are numbered as in a heap: the root is 1, the children of n are 2n and 2n + 1. The places
// are the nodes, too: an operation that reads the value of a node subscribes to its place.
#ifndef DYNMESH_EXAMPLES_MAXIMUM_PROGRAM_H_
#define DYNMESH_EXAMPLES_MAXIMUM_PROGRAM_H_

#include <dynmesh/sac/engine.h>
#include <dynmesh/sac/engine_audit.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

class MaximumProgram;

// What the engine keeps for the program with each operation: here, what the filters need. (3)
struct MaximumPayload {
  std::int64_t greatest = 0;  // of the values that the operation read
};

template <>
struct dynmesh::sac::PayloadOf<MaximumProgram> {
  using Type = MaximumPayload;
};

// Thread-compatible.
class MaximumProgram {
 public:
  using Engine = dynmesh::sac::Engine<MaximumProgram>;
  using Context = Engine::Context;
  using Kind = dynmesh::sac::Kind;
  using Item = dynmesh::sac::Item;
  using OpId = dynmesh::sac::OpId;
  using Output = dynmesh::sac::Output;
  using Stamp = dynmesh::sac::Stamp;

  // For 2^height values.
  explicit MaximumProgram(int height)
      : leaves_(Item{1} << height), nodes_(std::size_t{2} << height), engine_(*this) {}

  // --- Input, between propagations ----------------------------------------------------------

  // The environment requests an operation for each leaf that has a value. Operations for the nodes
  // above it exist because these request them.
  void Set(std::uint32_t index, std::int64_t value) {
    Node& leaf = nodes_[leaves_ + index];
    if (!leaf.has_input) {
      engine_.Request(kLeaf, leaves_ + index, 0);
    } else if (leaf.input != value) {
      // Input that an operation reads on its own item needs no place. (3)
      engine_.NotifyChain(leaf.operations, engine_.beginning());
    }
    leaf.has_input = true;
    leaf.input = value;
  }
  void Remove(std::uint32_t index) {
    Node& leaf = nodes_[leaves_ + index];
    if (leaf.has_input) engine_.Unrequest(kLeaf, leaves_ + index, 0);
    leaf.has_input = false;
  }

  // --- Results, after Engine::Propagate -------------------------------------------------------

  // None without values.
  std::optional<std::int64_t> Greatest() const {
    const std::uint32_t record = nodes_[kRoot].record;
    if (record == kNone) return std::nullopt;
    return records_[record].value;
  }
  Engine& engine() { return engine_; }
  // The node of an operation.
  Item NodeOf(OpId op) const { return engine_.item(op); }

  // A hash of the trace. It hashes by value, so it does not depend on how the trace came to be. (7)
  // Problems that the engine's audit finds are added to `problems`.
  std::uint64_t HashOfTrace(std::vector<std::string>* problems) const {
    return engine_.Audit([](Kind, Item node) { return Mixed(node); },
                         [this](OpId op) {
                           auto hash = static_cast<std::uint64_t>(engine_.payload(op).greatest);
                           for (const Output o : engine_.outputs(op)) {
                             hash = Mixed(hash) ^ static_cast<std::uint64_t>(records_[o].value);
                           }
                           return hash;
                         },
                         [](OpId, std::uint64_t) {}, problems);
  }

  // --- For the engine -------------------------------------------------------------------------

  // The order of time: epochs, here the height above the leaves; then by this hash. (1)
  std::uint64_t Priority(Kind, Item node) const { return Mixed(node); }
  bool Before(Kind, Item a, Kind, Item b) const { return a < b; }
  OpId& OperationsOf(Kind, Item node) { return nodes_[node].operations; }
  const OpId& OperationsOf(Kind, Item node) const { return nodes_[node].operations; }

  void Execute(Context& context) {
    const Item node = context.item;
    std::int64_t value = nodes_[node].input;
    if (context.kind == kInner) {
      value = std::numeric_limits<std::int64_t>::min();
      for (const Item child : {2 * node, 2 * node + 1}) {
        context.Subscribe(child);
        const std::uint32_t record = nodes_[child].record;
        if (record == kNone || !context.Sees(records_[record].birth)) continue;
        value = std::max(value, records_[record].value);
      }
      context.payload().greatest = value;
    }
    Emit(context, value);
    if (node != kRoot) context.Request(kInner, node / 2, context.epoch + 1);  // later: (6)
  }

  // The output is visible from time `at` on. Of its readers only those run again that read no value
  // as great. (3)
  void Publish(Output output, Stamp at) {
    const Record& record = records_[output];
    nodes_[record.node].record = output;
    engine_.Notify(record.node, at, dynmesh::sac::kNoStamp,
                   [&](OpId op) { return record.value > engine_.payload(op).greatest; });
  }
  // It is not visible any more. It matters to readers that have found no greater value.
  void Withdraw(Output output, Stamp at) {
    const Record& record = records_[output];
    if (nodes_[record.node].record == output) nodes_[record.node].record = kNone;
    engine_.Notify(record.node, at, dynmesh::sac::kNoStamp,
                   [&](OpId op) { return record.value == engine_.payload(op).greatest; });
  }
  // After the propagation: now the record may be used again. (5)
  void Release(Output output) { free_records_.push_back(output); }

 private:
  enum : Kind { kLeaf, kInner };
  static constexpr Item kRoot = 1;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Node {
    OpId operations = dynmesh::sac::kNoOp;
    std::uint32_t record = kNone;  // with its value; a leaf's, too
    bool has_input = false;
    std::int64_t input = 0;
  };
  // An object that operations make. It never changes: another value is another record. (2)
  struct Record {
    Item node = 0;
    std::int64_t value = 0;
    Stamp birth = 0;  // the time of the operation that made it
  };

  // Uniform, and a function of the item alone.
  static std::uint64_t Mixed(std::uint64_t x) {
    x = (x ^ x >> 31) * 0x9e3779b97f4a7c15;
    return (x ^ x >> 29) * 0xbf58476d1ce4e5b9;
  }

  // An equal record of the previous execution is kept, so that nothing follows from it. (2)
  void Emit(Context& context, std::int64_t value) {
    for (const Output old : context.old_outputs()) {
      if (records_[old].value == value) return context.Emit(old);
    }
    if (free_records_.empty()) {
      free_records_.push_back(static_cast<std::uint32_t>(records_.size()));
      records_.emplace_back();
    }
    const std::uint32_t record = free_records_.back();
    free_records_.pop_back();
    records_[record] = {context.item, value, context.now};
    context.Emit(record);
  }

  const Item leaves_;
  std::vector<Node> nodes_;
  std::vector<Record> records_;
  std::vector<std::uint32_t> free_records_;
  Engine engine_;
};

#endif  // DYNMESH_EXAMPLES_MAXIMUM_PROGRAM_H_
