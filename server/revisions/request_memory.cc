#include "server/revisions/request_memory.h"

#include <bit>
#include <utility>
#include <vector>

#include "core/base/mix.h"

namespace dynmesh::server {

namespace {

template <class Add>
void AddLabel(const FeatureLabel& label, Add add) {
  constexpr std::uint64_t kMark = 0x6c6162656cu;  // no number of rings or edits
  add(kMark);
  add(static_cast<std::uint64_t>(label.marker));
  add(label.name.size());
  std::uint64_t word = 0;
  std::size_t bytes = 0;
  for (const char c : label.name) {
    word = word << 8 | static_cast<unsigned char>(c);
    if (++bytes % sizeof(word) == 0) add(std::exchange(word, 0));
  }
  add(word);
}

}  // namespace

Fingerprint FingerprintOf(const EditBatch& batch) {
  Fingerprint f{0x9e3779b97f4a7c15u, 0xd1b54a32d192ed03u};
  const auto add = [&f](std::uint64_t word) {
    f.a = MixBits(f.a + word);
    f.b = MixBits(f.b ^ (word + 0x632be59bd9b4e019u));
  };
  add(batch.size());
  for (const Edit& edit : batch) {
    add(static_cast<std::uint64_t>(edit.action));
    add(edit.feature.id);
    add(static_cast<std::uint64_t>(edit.feature.kind));
    for (const double x : edit.feature.position) add(std::bit_cast<std::uint64_t>(x));
    for (const FeatureId end : edit.feature.ends) add(end);
    const Sizing& sizing = edit.feature.sizing;
    add(static_cast<std::uint64_t>(sizing.shape));
    for (const double x :
         {sizing.target, sizing.radius, sizing.hi[0], sizing.hi[1], sizing.hi[2]}) {
      add(std::bit_cast<std::uint64_t>(x));
    }
    // Fingerprints of other features are as they were before there was a path.
    if (!sizing.path.empty()) add(sizing.path.size());
    for (const auto& vertex : sizing.path) {
      for (const double x : vertex) add(std::bit_cast<std::uint64_t>(x));
    }
    add(edit.feature.rings.size());
    for (const std::vector<FeatureId>& ring : edit.feature.rings) {
      add(ring.size());
      for (const FeatureId id : ring) add(id);
    }
    // Fingerprints without labels are as they were before there were any.
    if (edit.feature.label) AddLabel(*edit.feature.label, add);
  }
  return f;
}

Fingerprint FingerprintOfRevert(std::uint64_t revision) {
  Edit edit;
  edit.action = static_cast<Edit::Action>(0);  // no edit has this value
  edit.feature.id = revision;
  return FingerprintOf({edit});
}

const RequestMemory::Entry* RequestMemory::Find(absl::string_view request_id) const {
  const auto it = entries_.find(request_id);
  return it == entries_.end() ? nullptr : &it->second;
}

void RequestMemory::Remember(std::string request_id, const Entry& entry) {
  if (capacity_ == 0) return;
  if (order_.size() == capacity_) {
    entries_.erase(order_.front());
    order_.pop_front();
  }
  entries_.emplace(request_id, entry);
  order_.push_back(std::move(request_id));
}

}  // namespace dynmesh::server
