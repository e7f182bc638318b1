// Columns of a SlotMesh with their free slots: subsegments or subfacets by key. One thread.
#ifndef DYNMESH_CORE_MESH_DATA_SLOT_COLUMNS_H_
#define DYNMESH_CORE_MESH_DATA_SLOT_COLUMNS_H_

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/status/status.h"
#include "core/base/text.h"
#include "core/mesh_data/constraints.h"
#include "dynmesh/slot_mesh.h"

namespace dynmesh::mesh_data {

inline std::size_t At(Slot slot) { return static_cast<std::size_t>(slot); }

// The error of a diff that does not fit the mesh.
inline absl::Status Lost(std::string_view what, std::string_view trouble) {
  return absl::DataLossError(text::Concat(what, " ", trouble, ": take a new snapshot"));
}

// Free slots of a kind, and their total number.
struct SlotPool {
  std::vector<Slot> free;
  Slot end = 0;  // slots 0 ... end - 1 were handed out
  Slot Take() {
    if (free.empty()) return end++;
    const Slot slot = free.back();
    free.pop_back();
    return slot;
  }
};

// Subsegments or subfacets by key, in slots.
template <class Columns>
struct ConstraintTable {
  static constexpr std::size_t kCorners = mesh_data::kCorners<Columns>;
  using Key = ConstraintKey<Columns>;

  absl::flat_hash_map<Key, Slot> slots;
  SlotColumn<Slot> corners;
  SlotColumn<FeatureId> owners;
  SlotPool pool;

  // Computes the net effect of a diff, and adds it to `hash`.
  absl::Status Net(const Columns& removed, const Columns& added, MeshHash& hash) const {
    const std::string what = text::Concat("a ", kConstraintName<Columns>);
    absl::flat_hash_set<Key> gone, come;
    for (std::size_t i = 0; i < removed.size(); ++i) {
      const auto key = KeyOf(removed, i);
      if (!slots.contains(key)) return Lost(what, "is to go but is absent");
      if (!gone.insert(key).second) return Lost(what, "goes twice");
      hash -= HashOf(key);
    }
    for (std::size_t i = 0; i < added.size(); ++i) {
      const auto key = KeyOf(added, i);
      if (slots.contains(key) && !gone.contains(key)) {
        return Lost(what, "is to come but is present");
      }
      if (!come.insert(key).second) return Lost(what, "comes twice");
      hash += HashOf(key);
    }
    return absl::OkStatus();
  }

  // `slot_of` finds a vertex by id.
  template <class SlotOf>
  void Commit(const Columns& removed, const Columns& added, const SlotOf& slot_of) {
    for (std::size_t i = 0; i < removed.size(); ++i) {
      const auto it = slots.find(KeyOf(removed, i));
      const Slot slot = it->second;
      slots.erase(it);
      for (std::size_t k = 0; k < kCorners; ++k) corners[At(slot) * kCorners + k] = kNoSlot;
      owners[At(slot)] = kNoFeature;
      pool.free.push_back(slot);
    }
    for (std::size_t i = 0; i < added.size(); ++i) {
      const auto key = KeyOf(added, i);
      const Slot slot = pool.Take();
      slots.emplace(key, slot);
      corners.resize(At(pool.end) * kCorners, kNoSlot);
      owners.resize(At(pool.end), kNoFeature);
      for (std::size_t k = 0; k < kCorners; ++k) {
        corners[At(slot) * kCorners + k] = slot_of(key[k]);
      }
      owners[At(slot)] = key[kCorners];
    }
  }

  // Appends to both the rows that stay and have a replaced corner.
  template <class IsReplaced>
  void AddReplaced(const IsReplaced& is_replaced, Columns& removed, Columns& added) const {
    absl::flat_hash_set<Key> gone;
    for (std::size_t i = 0; i < removed.size(); ++i) gone.insert(KeyOf(removed, i));
    for (const auto& [key, slot] : slots) {
      if (gone.contains(key) || std::none_of(key.begin(), key.end() - 1, is_replaced)) continue;
      Append(removed, key), Append(added, key);
    }
  }

  Columns ToColumns() const {
    Columns columns;
    for (const auto& [key, slot] : slots) Append(columns, key);
    return columns;
  }
};

}  // namespace dynmesh::mesh_data

#endif  // DYNMESH_CORE_MESH_DATA_SLOT_COLUMNS_H_
