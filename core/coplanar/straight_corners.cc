#include "core/coplanar/straight_corners.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/geometry/circumball.h"
#include "core/geometry/collinear.h"

namespace dynmesh::coplanar {

using geometry::Point3;

namespace {

class Dropper {
 public:
  Dropper(const std::vector<Point3>& positions, const std::vector<bool>& kept,
          const std::vector<FaceRings>& faces, const std::function<double(Corner)>& within)
      : positions_(positions), kept_(kept), within_(within), at_(positions.size()) {
    for (const FaceRings& face : faces) {
      for (const CornerRing& ring : face) AddRing(ring);
    }
  }

  void Run() {
    std::vector<Corner> open(positions_.size());
    std::iota(open.begin(), open.end(), Corner{0});
    while (!open.empty()) {
      const Corner c = open.back();
      open.pop_back();
      const std::optional<CornerPair> ends = EndsOf(c);
      if (!ends) continue;
      if (within_) Gather(*ends, c);
      for (const std::size_t n : at_[c]) {
        nodes_[nodes_[n].before].behind = nodes_[n].behind;
        nodes_[nodes_[n].behind].before = nodes_[n].before;
        nodes_[n].gone = true;
        --sizes_[nodes_[n].ring];
      }
      at_[c].clear();
      open.push_back(ends->first);  // their neighbours have changed
      open.push_back(ends->second);
    }
  }

  void Write(std::vector<FaceRings>& faces) const {
    auto node = nodes_.begin();
    for (FaceRings& face : faces) {
      for (CornerRing& ring : face) {
        std::erase_if(ring, [&](Corner) { return (node++)->gone; });
      }
    }
  }

 private:
  struct Node {
    Corner corner;
    std::size_t before, behind, ring;
    bool gone = false;
  };

  void AddRing(const CornerRing& ring) {
    const std::size_t first = nodes_.size(), n = ring.size();
    for (std::size_t i = 0; i < n; ++i) {
      at_[ring[i]].push_back(nodes_.size());
      nodes_.push_back({ring[i], first + (i + n - 1) % n, first + (i + 1) % n, sizes_.size()});
    }
    sizes_.push_back(n);
  }

  // Those dropped between two corners.
  std::span<const Corner> DroppedBetween(Corner p, Corner q) const {
    const auto it = dropped_.find(std::minmax(p, q));
    return it == dropped_.end() ? std::span<const Corner>() : it->second;
  }

  void Gather(const CornerPair& ends, Corner c) {
    std::vector<Corner> all = {c};
    for (const Corner end : {ends.first, ends.second}) {
      const std::span<const Corner> before = DroppedBetween(end, c);
      all.insert(all.end(), before.begin(), before.end());
    }
    dropped_[ends] = std::move(all);
  }

  bool IsBeside(Corner p, Corner c, Corner q) const {
    const geometry::Vector3 way = geometry::Difference(positions_[q].c, positions_[p].c);
    const double along = geometry::Dot(way, geometry::Difference(positions_[c].c, positions_[p].c));
    return along > 0 && along < geometry::Dot(way, way) &&
           geometry::DistanceToLine(positions_[c], positions_[p], positions_[q]) <= within_(c);
  }

  // All that was between p and q, and c.
  bool AreBeside(Corner p, Corner c, Corner q) const {
    if (!within_ || !IsBeside(p, c, q)) return false;
    for (const Corner end : {p, q}) {
      for (const Corner other : DroppedBetween(end, c)) {
        if (!IsBeside(p, other, q)) return false;
      }
    }
    return true;
  }

  // The two corners around c, if c is not needed between them.
  std::optional<CornerPair> EndsOf(Corner c) const {
    if (kept_[c] || at_[c].empty()) return std::nullopt;
    std::optional<CornerPair> ends;
    for (const std::size_t n : at_[c]) {
      const Node& node = nodes_[n];
      if (sizes_[node.ring] <= 3) return std::nullopt;
      const CornerPair pair = std::minmax(nodes_[node.before].corner, nodes_[node.behind].corner);
      if (ends && *ends != pair) return std::nullopt;
      ends = pair;
    }
    // On a line the lexicographic order is that along it.
    const auto [p, q] = *ends;
    const bool is_straight = positions_[p] < positions_[c] && positions_[c] < positions_[q] &&
                             geometry::AreCollinear(positions_[p], positions_[c], positions_[q]);
    if (is_straight && !within_) return ends;
    return AreBeside(p, c, q) ? ends : std::nullopt;
  }

  const std::vector<Point3>& positions_;
  const std::vector<bool>& kept_;
  const std::function<double(Corner)>& within_;
  absl::flat_hash_map<CornerPair, std::vector<Corner>> dropped_;  // by what is joined now
  std::vector<Node> nodes_;                                       // ring by ring
  std::vector<std::size_t> sizes_;                                // of rings
  std::vector<std::vector<std::size_t>> at_;                      // nodes, by corner
};

}  // namespace

void DropStraightCorners(const std::vector<Point3>& positions, const std::vector<bool>& kept,
                         std::vector<FaceRings>& faces,
                         const std::function<double(Corner)>& within) {
  Dropper dropper(positions, kept, faces, within);
  dropper.Run();
  dropper.Write(faces);
}

}  // namespace dynmesh::coplanar
