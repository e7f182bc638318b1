#include "server/cluster/placement.h"

#include <algorithm>
#include <utility>

namespace dynmesh::server {
namespace {

// FNV-1a.
std::uint64_t Absorb(std::uint64_t hash, absl::string_view bytes) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

// Of equal weights the smaller name is first.
bool IsBefore(absl::string_view node, std::uint64_t weight, absl::string_view other,
              std::uint64_t other_weight) {
  return weight > other_weight || (weight == other_weight && node < other);
}

}  // namespace

std::uint64_t PlacementWeight(absl::string_view node, absl::string_view mesh) {
  // A zero byte, which no name has, keeps "ab" with "c" apart from "a" with "bc".
  std::uint64_t hash = Absorb(0xcbf29ce484222325, node);
  hash = Absorb(hash, absl::string_view("\0", 1));
  hash = Absorb(hash, mesh);
  // The high bits of FNV hardly depend on the last bytes; the comparison of weights is by these.
  hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9;
  hash = (hash ^ (hash >> 27)) * 0x94d049bb133111eb;
  return hash ^ (hash >> 31);
}

std::optional<std::size_t> ChooseNode(const std::vector<std::string>& nodes,
                                      absl::string_view mesh) {
  std::optional<std::size_t> best;
  std::uint64_t best_weight = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::uint64_t weight = PlacementWeight(nodes[i], mesh);
    if (!best.has_value() || IsBefore(nodes[i], weight, nodes[*best], best_weight)) {
      best = i;
      best_weight = weight;
    }
  }
  return best;
}

std::vector<std::string> NextNodes(const std::vector<std::string>& nodes, absl::string_view owner,
                                   absl::string_view mesh, std::size_t count) {
  std::vector<std::pair<std::uint64_t, const std::string*>> weighed;
  for (const std::string& node : nodes) {
    if (node != owner) weighed.emplace_back(PlacementWeight(node, mesh), &node);
  }
  count = std::min(count, weighed.size());
  std::partial_sort(weighed.begin(), weighed.begin() + static_cast<std::ptrdiff_t>(count),
                    weighed.end(), [](const auto& a, const auto& b) {
                      return IsBefore(*a.second, a.first, *b.second, b.first);
                    });
  std::vector<std::string> next;
  for (std::size_t i = 0; i < count; ++i) next.push_back(*weighed[i].second);
  return next;
}

}  // namespace dynmesh::server
